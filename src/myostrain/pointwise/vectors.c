/* Numbers of several nodes at once, in vectors as wide as the processor's, and functions of them. Nothing
   branches and no node sees another one: what comes out at a node does not depend on its place. */

#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#define INLINE static inline __attribute__((always_inline))
/* Long functions exist once and are called. */
#define SHARED static __attribute__((noinline))

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define WIDE 1
enum { LANES = 8 };
#define EACH(x) {(x), (x), (x), (x), (x), (x), (x), (x)}
#elif defined(__AVX__)
enum { LANES = 4 };
#define EACH(x) {(x), (x), (x), (x)}
#else
enum { LANES = 2 };
#define EACH(x) {(x), (x)}
#endif

typedef double vec __attribute__((vector_size(8*LANES)));
typedef uint64_t bits __attribute__((vector_size(8*LANES)));
typedef double unaligned __attribute__((vector_size(8*LANES), aligned(8), may_alias));

INLINE vec all(double x) { return (vec)EACH(x); }
INLINE double first(vec x) { return x[0]; }
/* What comes next is asked for: there are more arrays than a processor foresees. */
INLINE vec load(const double *p)
{
  __builtin_prefetch(p + 8*LANES);
  return *(const unaligned *)p;
}
INLINE void store(double *p, vec x)
{
  __builtin_prefetch(p + 8*LANES, 1);
  *(unaligned *)p = x;
}

#ifdef WIDE

/* Truth values are the processor's masks. */
typedef __mmask8 truth;
INLINE truth truth_of(int c) { return c ? 0xff : 0; }
INLINE truth lt(vec a, vec b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
INLINE truth le(vec a, vec b) { return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ); }
INLINE truth eq(vec a, vec b) { return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ); }
INLINE truth ne(vec a, vec b) { return _mm512_cmp_pd_mask(a, b, _CMP_NEQ_UQ); }
INLINE truth and(truth a, truth b) { return a & b; }
INLINE truth or(truth a, truth b) { return a | b; }
INLINE truth not(truth a) { return ~a; }
INLINE vec where(truth m, vec a, vec b) { return _mm512_mask_blend_pd(m, b, a); }
INLINE int first_false(truth m) { return m == 0xff ? -1 : __builtin_ctz(~(unsigned)m); }
INLINE vec min(vec a, vec b) { return _mm512_min_pd(a, b); } /* a < b ? a : b, so is max */
INLINE vec max(vec a, vec b) { return _mm512_max_pd(a, b); }
INLINE vec root(vec a) { return _mm512_sqrt_pd(a); }

#else

/* Truth values are masks of 64 bits. */
typedef bits truth;
INLINE truth truth_of(int c) { return (truth)EACH(c ? ~(uint64_t)0 : 0); }
INLINE truth lt(vec a, vec b) { return (truth)(a < b); }
INLINE truth le(vec a, vec b) { return (truth)(a <= b); }
INLINE truth eq(vec a, vec b) { return (truth)(a == b); }
INLINE truth ne(vec a, vec b) { return (truth)(a != b); }
INLINE truth and(truth a, truth b) { return a & b; }
INLINE truth or(truth a, truth b) { return a | b; }
INLINE truth not(truth a) { return ~a; }
INLINE vec where(truth m, vec a, vec b) { return (vec)(((bits)a & m) | ((bits)b & ~m)); }
INLINE int first_false(truth m)
{
  uint64_t every = m[0];
  for (int l = 1; l < LANES; ++l) every &= m[l];
  if (every) return -1;
  for (int l = 0;; ++l)
    if (!m[l]) return l;
}
INLINE vec min(vec a, vec b) { return where(lt(a, b), a, b); }
INLINE vec max(vec a, vec b) { return where(lt(b, a), a, b); }
INLINE vec root(vec a)
{
  for (int l = 0; l < LANES; ++l) a[l] = sqrt(a[l]);
  return a;
}

#endif

/* Numbers below 1e-308 are taken for zero: processors are a hundred times slower with them. */
static unsigned without_tiny(void)
{
#ifdef __SSE2__
  const unsigned modes = _mm_getcsr();
  _mm_setcsr(modes | 0x8040);
  return modes;
#else
  return 0;
#endif
}
static void with_modes(unsigned modes)
{
#ifdef __SSE2__
  _mm_setcsr(modes);
#else
  (void)modes;
#endif
}

/* e^x = 2^n e^r with |r| <= ln(2)/2; e^r - 1 by a polynomial whose relative error is below 2e-17. */
INLINE vec small_expm1(vec r)
{
  const vec q = r*r, w = q*q;
  const vec a = r*0.16666666666666685 + 0.5000000000000006;
  const vec b = r*0.008333333333314649 + 0.04166666666657403;
  const vec c = r*0.00019841269902917617 + 0.0013888888932281484;
  const vec d = r*2.75572280461341e-06 + 2.480150453715119e-05;
  const vec e = r*2.5114446309281685e-08 + 2.762629736192964e-07;
  return ((w*e + (d*q + c))*w + (b*q + a))*q + r;
}
/* x = n ln(2)/parts + r, and bits of n at the end of those of ``count``. */
INLINE vec reduced(vec x, double parts, bits *count)
{
  x = min(all(708.0), max(all(-708.0), x)); /* NaN stays */
  const vec shift = all(6755399441055744.0); /* 1.5 * 2^52: its last bits count the unit */
  const vec t = x*(parts*1.4426950408889634074) + shift, n = t - shift;
  *count = (bits)t;
  return (x - n*(6.93147180369123816490e-01/parts)) - n*(1.90821492927058770002e-10/parts);
}
INLINE vec power_of_two(bits count) { return (vec)((count << 52) + 0x3ff0000000000000); }
SHARED vec own_expm1(vec x)
{
  bits count;
  const vec r = reduced(x, 1.0, &count), scale = power_of_two(count);
  return scale*small_expm1(r) + (scale - 1.0);
}
#ifdef WIDE
/* 2^(j/16) less j 2^48, so that the count of sixteenths, moved by 48 bits, is all there is to add. */
static const uint64_t POWERS[16] = {
  0x3ff0000000000000, 0x3fefb5586cf9890f, 0x3fef72b83c7d517b, 0x3fef387a6e756238,
  0x3fef06fe0a31b715, 0x3feedea64c123422, 0x3feebfdad5362a27, 0x3feeab07dd485429,
  0x3feea09e667f3bcd, 0x3feea11473eb0187, 0x3feeace5422aa0db, 0x3feec49182a3f090,
  0x3feee89f995ad3ad, 0x3fef199bdd85529c, 0x3fef5818dcfba487, 0x3fefa4afa2a490da,
};
SHARED vec own_exp(vec x)
{
  bits count;
  const vec r = reduced(x, 16.0, &count), q = r*r;
  const __m512i low = _mm512_loadu_si512(POWERS), high = _mm512_loadu_si512(POWERS + 8);
  const vec scale = (vec)((bits)_mm512_permutex2var_epi64(low, (__m512i)count, high) + (count << 48));
  vec p = all(0.0013889129022831607);
  p = p*r + 0.008333471994433713;
  p = p*r + 0.04166666665965745;
  p = p*r + 0.16666666664416213;
  p = p*r + 0.5000000000000006;
  return scale*(p*q + r) + scale;
}
#else
SHARED vec own_exp(vec x)
{
  bits count;
  const vec r = reduced(x, 1.0, &count), scale = power_of_two(count);
  return scale*small_expm1(r) + scale;
}
#endif
/* log x = n log 2 + 2 artanh((m - 1)/(m + 1)) with m between 1/sqrt(2) and sqrt(2). */
SHARED vec own_log(vec x)
{
  const bits b = (bits)x - 0x3fe6a09e667f3bcd;
  const vec m = (vec)((b & 0xfffffffffffff) + 0x3fe6a09e667f3bcd);
  const vec n = (vec)(((b + 0x4000000000000000) >> 52) + 0x4330000000000000) - 4503599627371520.0;
  const vec s = (m - 1.0)/(m + 1.0), q = s*s;
  vec p = all(0.14618008967187285);
  p = p*q + 0.1533158591338376;
  p = p*q + 0.18182893551820517;
  p = p*q + 0.22222211068256267;
  p = p*q + 0.28571428626427425;
  p = p*q + 0.39999999999898384;
  p = p*q + 0.666666666666667;
  const vec y = n*6.93147180369123816490e-01 + ((2.0*s + s*q*p) + n*1.90821492927058770002e-10);
  const vec none = where(eq(x, all(0.0)), all(-INFINITY), all(NAN));
  return where(lt(all(0.0), x), y, none);
}
INLINE vec own_pow(vec x, vec y) { return own_exp(y*own_log(x)); }
INLINE vec magnitude(vec x) { return (vec)((bits)x & 0x7fffffffffffffff); }
SHARED vec own_tanh(vec x)
{
  const vec e = own_expm1(2.0*x);
  return e/(e + 2.0);
}
SHARED vec own_sinh(vec x)
{
  const vec e = own_expm1(magnitude(x)), y = 0.5*(e + e/(e + 1.0));
  return (vec)((bits)y | ((bits)x & 0x8000000000000000));
}
SHARED vec own_cosh(vec x)
{
  const vec e = own_exp(x);
  return 0.5*(e + 1.0/e);
}
SHARED vec own_log1p(vec x)
{
  const vec u = 1.0 + x;
  return own_log(u) - ((u - 1.0) - x)/u;
}

/* What the C library computes, lane by lane. */
#define LIBRARY(name) \
  static vec each_##name(vec x) \
  { \
    for (int l = 0; l < LANES; ++l) x[l] = name(x[l]); \
    return x; \
  }
LIBRARY(sin)
LIBRARY(cos)
LIBRARY(tan)
LIBRARY(asin)
LIBRARY(acos)
LIBRARY(atan)
LIBRARY(floor)
LIBRARY(ceil)
