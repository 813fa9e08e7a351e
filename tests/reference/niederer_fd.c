/* The N-version benchmark by finite differences: an independent reference; niederer_fd.py makes and runs it.
 *
 * Central differences of fourth order on a grid, mirrored at the faces; explicit in time, of second order: with
 * u half way by extrapolation, v += dt (div D grad u + R + S), gates by exponentials at u, the current R with
 * gates half way. Nodes where v changes slowly take their reaction each K steps only, and none 6 ms after their
 * activation: a front does not feel what lies a hundred lengths behind it. A node on a face of the stimulated
 * cube has half of the stimulus, so that the cube has its size on every grid.
 *
 * Arguments: spacings along and across, step, K, threshold of "slowly" (mV/ms), lengths x, y, z, conductivities
 * (mm2/ms), side of the cube, end. Prints the times at which v is 0 mV at the corners P1 ... P8 and the centre P9.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "membrane.h" /* NS states, NB nodes a batch, Y0, V0, and membrane(n, u, states, rate, dt) */

#define RATE 35.714285714285715 /* 50 uA/mm3 over chi Cm, for 2 ms */
#define GONE 6.0
#define NODES for (long z = 0, i = 0; z < n[2]; z++) for (long y = 0; y < n[1]; y++) \
  for (long x = 0, p = (z + 2) * s[2] + (y + 2) * s[1] + 2; x < n[0]; x++, i++, p++)

static double *full(long count, double value)
{
  double *a = malloc(count * sizeof *a);
  for (long i = 0; i < count; i++) a[i] = value;
  return a;
}

int main(int argc, char **argv)
{
  double a[13];
  for (int i = 0; i < 13; i++) a[i] = i + 1 < argc ? atof(argv[i + 1]) : 0;
  const double h[3] = {a[0], a[1], a[1]}, dt = a[2], slow = a[4], *L = a + 5, *D = a + 8, cube = a[11], end = a[12];
  const int K = (int)a[3];
  long n[3], m[3], N = 1;
  for (int k = 0; k < 3; k++) n[k] = (long)(L[k] / h[k] + 1.5), m[k] = n[k] + 4, N *= n[k];
  const long s[3] = {1, m[0], m[0] * m[1]}, M = s[2] * m[2];
  double *v = full(M, V0), *before = full(M, V0), *u = full(M, V0), *R = full(N, 0), *S = full(N, RATE);
  double *act = full(N, -1), *Y = malloc(N * sizeof Y0);
  char *kind = calloc(N, 1); /* 1: each step, 0: each K steps, 2: gone */
  for (long i = 0; i < N; i++) memcpy(Y + i * NS, Y0, sizeof Y0);
  NODES {
    const long c[3] = {x, y, z};
    for (int k = 0; k < 3; k++) {
      double part = cube / h[k] - c[k] + 0.5;
      S[i] *= part < 0 ? 0 : part > 1 ? 1 : part;
    }
  }
  double near[3], far[3], own = 0; /* (-1, 16, -30, 16, -1)/12 */
  for (int k = 0; k < 3; k++) near[k] = D[k] / h[k] / h[k] * 16 / 12, far[k] = -near[k] / 16, own -= 2 * (near[k] + far[k]);
  double states[NS * NB], at[NB], rate[NB];
  long batch[NB];
  for (long q = 0; q * dt < end && act[N - 1] < 0; q++) {
    const double now = q * dt;
    for (long p = 0; p < M; p++) u[p] = 1.5 * v[p] - 0.5 * before[p];
    for (int k = 0; k < 3; k++) /* two mirrored layers on both sides, axis after axis */
      for (long j = 0; j < m[(k + 2) % 3]; j++) for (long i = 0; i < m[(k + 1) % 3]; i++) {
        double *line = u + i * s[(k + 1) % 3] + j * s[(k + 2) % 3];
        for (int g = 1; g <= 2; g++) {
          line[(2 - g) * s[k]] = line[(2 + g) * s[k]];
          line[(n[k] + 1 + g) * s[k]] = line[(n[k] + 1 - g) * s[k]];
        }
      }
    if (q % K == 0) NODES {
      double change = (v[p] - before[p]) / dt;
      int front = change > slow || change < -slow || (v[p] > -80 && v[p] < 5 && act[i] < 0);
      kind[i] = act[i] >= 0 && now - act[i] > GONE ? 2 : front || (now < 2.1 && S[i] > 0);
      if (kind[i] == 2) R[i] = 0;
    }
    for (int pass = 1; pass >= (q % K ? 1 : 0); pass--) {
      int fill = 0;
      NODES {
        if (kind[i] == pass) {
          batch[fill] = i, at[fill] = u[p];
          for (int k = 0; k < NS; k++) states[k * NB + fill] = Y[i * NS + k];
          fill++;
        }
        if (fill == NB || (fill && i == N - 1)) {
          membrane(fill, at, states, rate, pass ? dt : K * dt);
          for (int b = 0; b < fill; b++) {
            R[batch[b]] = rate[b];
            for (int k = 0; k < NS; k++) Y[batch[b] * NS + k] = states[k * NB + b];
          }
          fill = 0;
        }
      }
    }
    const double on = now < 2 - 1e-9;
    NODES {
      double flow = own * u[p];
      for (int k = 0; k < 3; k++)
        flow += near[k] * (u[p + s[k]] + u[p - s[k]]) + far[k] * (u[p + 2 * s[k]] + u[p - 2 * s[k]]);
      before[p] = v[p] + dt * (flow + R[i] + on * S[i]);
    }
    double *swap = v;
    v = before, before = swap;
    NODES if (act[i] < 0 && v[p] >= 0) act[i] = now - dt * before[p] / (v[p] - before[p]);
  }
  const int order[8] = {0, 2, 1, 3, 4, 6, 5, 7}; /* P1 ... P8: bits say which end of x, y, z */
  double centre = 0;
  for (int k = 0; k < 8; k++) {
    int c = order[k];
    long i = ((c & 4 ? n[2] - 1 : 0) * n[1] + (c & 2 ? n[1] - 1 : 0)) * n[0] + (c & 1 ? n[0] - 1 : 0);
    printf("%.4f ", act[i]);
    i = (((n[2] - 1 + (c >> 2 & 1)) / 2) * n[1] + (n[1] - 1 + (c >> 1 & 1)) / 2) * n[0] + (n[0] - 1 + (c & 1)) / 2;
    centre += act[i] / 8; /* four or eight nodes about it, or itself */
  }
  printf("%.4f\n", centre);
  return 0;
}
