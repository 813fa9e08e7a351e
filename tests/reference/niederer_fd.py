"""The N-version benchmark of Niederer et al. 2011 by finite differences: an independent reference.

Shares nothing with myostrain: ``niederer_fd.c`` steps a grid, and the membrane is the C that gotranx makes of
the .ode of ten Tusscher and Panfilov 2006 in fenicsx-beat, with the initial states of the benchmark.

    python niederer_fd.py tentusscher_panfilov_2006_epi_cell.ode 0.1 0.05 0.009

makes, compiles and runs it, with gotranx and gcc: spacings along and across the fibre in mm, and the step in
ms (explicit: at most 3/16 / (D/h² summed)); it prints P1 ... P9.

What it gave, and what these numbers tend to (:func:`limit`), is below and in docs/niederer.md.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

#: Along and across the fibre, mm²/ms.
D = 0.17 * 0.62 / (0.17 + 0.62) / 1.4, 0.019 * 0.24 / (0.019 + 0.24) / 1.4

#: P1 ... P9 in ms by spacings along and across, mm, with steps of 0.01 and 0.009 ms; half the step changes
#: velocities by less than 0.05 %.
FOUND = {
    (0.2, 0.1): [1.2208, 28.6995, 32.9750, 42.7980, 8.8412, 30.2253, 34.2139, 43.7822, 20.2684],
    (0.1, 0.1): [1.2209, 28.6989, 31.8288, 42.3590, 8.8419, 30.2240, 33.0721, 43.3244, 19.9450],
    (0.1, 0.0667): [1.2209, 27.3472, 31.8263, 41.6597, 8.4868, 28.7721, 33.0382, 42.6428, 19.7102],
    (0.1, 0.05): [1.2208, 26.8644, 31.8242, 41.4990, 8.3601, 28.2823, 33.0324, 42.4907, 19.6608],
}

#: Velocities of a wave on a line by the same differences, mm/ms, by spacing; the last of each is the limit.
ALONG = {0.2: 0.58588, 0.1: 0.60805, 0.05: 0.61221, 0.0: 0.61265}
ACROSS = {0.1: 0.20436, 0.0667: 0.21469, 0.05: 0.21873, 0.0: 0.22277}


def limit():
    """P1 ... P9 without the errors of the grid, which go with those of the slowness along and across."""
    coarse_x, coarse_y, fine = (np.array(FOUND[h]) for h in ((0.2, 0.1), (0.1, 0.1), (0.1, 0.05)))

    def left(c, coarse, finer):
        return (1 / c[finer] - 1 / c[0.0]) / (1 / c[coarse] - 1 / c[finer])

    along = left(ALONG, 0.2, 0.1) * (coarse_x - coarse_y)
    across = left(ACROSS, 0.1, 0.05) * (coarse_y - fine)
    return fine - along - across


def membrane(ode):
    """C of a batch of nodes: gates by exponentials, current and concentrations with gates half way."""
    import gotranx

    text = gotranx.cli.gotran2c.get_code(gotranx.load_ode(Path(ode)))

    def section(name):
        part = text[text.index(f"void {name}(") :]
        return part[: part.index("\n}")]

    def values(name, of):
        return dict(re.findall(rf"{of}\[(\d+)\] = (.*?);", section(name)))

    lines = re.findall(r"const double (\w+) = (.*?);", section("rhs"), re.S)
    where = {n: re.findall(r"\d+", e)[0] for n, e in lines if e.startswith("states[")}
    formulas = {n: e for n, e in lines if not e.startswith(("states[", "parameters["))} | {"i_Stim": "0.0"}
    gates = {}
    for name, formula in formulas.items():
        if found := re.fullmatch(r"\(-(\w+) \+ (\w+)\)/(\w+)", formula):
            gates[found[1]] = found[2], found[3]
            assert name == f"d{found[1]}_dt"
    body, done = [], set()

    def write(name):
        if name in formulas and name not in done:
            done.add(name)
            for other in re.findall(r"[A-Za-z_]\w*", formulas[name]):
                write(other)
            body.append(f"const double {name} = {formulas[name]};")

    for pair in gates.values():
        for name in pair:
            write(name)
    for gate, (end, tau) in gates.items():
        body.append(f"const double {gate}_new = {end} + ({gate}_old - {end}) * exp(-dt / {tau});")
        body.append(f"const double {gate} = ({gate}_old + {gate}_new) / 2;")
    states = [name for name in where if name != "V"]
    for name in ["V", *(s for s in states if s not in gates)]:
        write(f"d{name}_dt")
    initial, numbers = values("init_state_values", "states"), values("init_parameter_values", "parameters")
    constants = [(n, numbers[re.findall(r"\d+", e)[0]]) for n, e in lines if e.startswith("parameters[")]
    return "\n".join([
        "#include <math.h>",
        "#define gamma gamma_",  # math.h has a function of this name
        f"#define NS {len(states)}",
        "#define NB 64",
        *(f"static const double {name} = {value};" for name, value in constants),
        f"static const double Y0[NS] = {{{', '.join(initial[where[s]] for s in states)}}};",
        f"static const double V0 = {initial[where['V']]};",
        "static void membrane(int n, const double *at, double *Y, double *rate, double dt) {",
        "#pragma omp simd",
        "for (int b = 0; b < n; b++) { const double V = at[b];",
        *(f"const double {s}{'_old' if s in gates else ''} = Y[{k} * NB + b];" for k, s in enumerate(states)),
        *body,
        *(
            f"Y[{k} * NB + b] = {f'{s}_new' if s in gates else f'{s} + dt * d{s}_dt'};"
            for k, s in enumerate(states)
        ),
        "rate[b] = dV_dt; } }\n",
    ])  # fmt: skip


def times(ode, along, across, step):
    """P1 ... P9 in ms."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "membrane.h").write_text(membrane(ode), encoding="utf-8")
        source, program = Path(__file__).with_suffix(".c"), f"{folder}/program"
        flags = ["-O3", "-march=native", "-ffast-math", "-fopenmp-simd", f"-I{folder}"]
        subprocess.run(["gcc", *flags, str(source), "-o", program, "-lmvec", "-lm"], check=True)
        given = [along, across, step, 5, 2.0, 20, 7, 3, D[0], D[1], D[1], 1.5, 130]
        done = subprocess.run([program, *map(str, given)], check=True, capture_output=True, text=True)
    return [float(word) for word in done.stdout.split()]


if __name__ == "__main__":
    print(*times(sys.argv[1], *map(float, sys.argv[2:5])))
