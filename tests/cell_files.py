"""Models of cells in three languages, written for the tests, and the same in Python."""

import numpy as np

#: One current with two gates, one of them with a gap at −47 mV, a leak, calcium, and a stimulus.
ODE = """
# A small cell.
parameters("Sodium", g_Na = ScalarParam(4.0, unit="mS"), E_Na = 40.0)
parameters("Stimulus", stim_amplitude = ScalarParam(20.0, unit="mV/ms"),
           stim_start = ScalarParam(5.0, unit="ms"), stim_duration = 1.0)
parameters("Leak", range = 5e-2)
states("Membrane", V = ScalarParam(-84.0, unit="mV"))
states("Gates", m = 0.02, h = 0.9, Ca_i = ScalarParam(0.1, unit="uM"))

expressions("Sodium")
alpha_m = 0.1*(V + 47.0)/(1 - exp(-(V + 47.0)/10))  # ms**-1
beta_m = 4*exp(-(V + 72)/18)
dm_dt = alpha_m*(1 - m) - beta_m*m
tau_h = Conditional(And(Gt(V, -60), Lt(V, 20)), 1.5, 8.0)
dh_dt = (1/(1 + exp((V + 70)/7)) - h)/tau_h
i_Na = g_Na*m**3*h*(V - E_Na)

expressions("Membrane")
i_Stim = Conditional(And(Ge(time, stim_start), Le(time, stim_start + stim_duration)), -stim_amplitude, 0)
i_leak = range*(V + 84) + 2**-1*Max(abs(V), 1) - -Gt(V, 0)
dV_dt = -(i_Na + i_leak + i_Stim)
dCa_i_dt = -0.01*i_Na - ln(Ca_i)*sqrt(Ca_i)
"""

#: The same, and a script and a protocol that nothing may run.
MMT = """
[[model]]
membrane.V = -84
ina.m = 0.02
ina.h = 0.9
ca.Ca_i = 0.1

[engine]
time = 0 [ms] bind time
    in [ms]
pace = 0 bind pace

[membrane]
dot(V) = -(ina.i_Na + leak.i + i_push)
    in [mV]
    label membrane_potential
i_push = -20 * engine.pace

[ina]
use membrane.V
dot(m) = alpha * (1 - m) - beta * m
    alpha = 0.1 * (V + 47) / (1 - exp(-(V + 47) / 10))
    beta = 4 * exp(-(V + 72) / 18)
dot(h) = (1 / (1 + exp((V + 70) / 7)) - h) / tau
    tau = if(V > -60 and V < 20, 1.5, 8)
gmax = 4
E = 40
i_Na = gmax * m^3 * h * (V - E)

[leak]
use membrane.V
range = 5e-2
i = range * (V + 84) + abs(V) / 2 + piecewise(abs(V) >= 1, 0, 0.5 - abs(V) / 2) + if(V > 0, 1, 0)

[ca]
dot(Ca_i) = -0.01 * ina.i_Na - log(Ca_i) * sqrt(Ca_i)
    in [uM]

[[protocol]]
1 5 1 1000 0

[[script]]
import pathlib
pathlib.Path("ran").write_text("the script ran")
"""


def ode_in_python(v, m, h, calcium):
    """Rates of the model above, by name."""
    y = -(v + 47) / 10
    alpha, beta = 0.1 * (v + 47) / (1 - np.exp(y)), 4 * np.exp(-(v + 72) / 18)
    sodium = 4.0 * m**3 * h * (v - 40)
    leak = 0.05 * (v + 84) + np.maximum(abs(v), 1) / 2 + (v > 0)
    tau = np.where((v > -60) & (v < 20), 1.5, 8.0)
    return {
        "V": -(sodium + leak),
        "m": alpha * (1 - m) - beta * m,
        "h": (1 / (1 + np.exp((v + 70) / 7)) - h) / tau,
        "Ca_i": -0.01 * sodium - np.log(calcium) * np.sqrt(calcium),
    }


def _mathml(of, formula, rate=False):
    left = f"<apply><diff/><bvar><ci>time</ci></bvar><ci>{of}</ci></apply>" if rate else f"<ci>{of}</ci>"
    return f"<apply><eq/>{left}{formula}</apply>"


def _apply(op, *args):
    return f"<apply><{op}/>{''.join(args)}</apply>"


def _ci(name):
    return f"<ci>{name}</ci>"


def _cn(value, units="dimensionless"):
    return f'<cn cellml:units="{units}">{value}</cn>'


def _variable(name, value=None, units="dimensionless"):
    initial = "" if value is None else f' initial_value="{value}"'
    return f'<variable name="{name}" units="{units}"{initial}/>'


_DURING = _apply("and", _apply("gt", _ci("time"), _cn(2, "ms")), _apply("lt", _ci("time"), _cn(3, "ms")))
_STIMULUS = (
    f"<piecewise><piece>{_ci('amplitude_of_stimulus')}{_DURING}</piece>"
    f"<otherwise>{_cn(0)}</otherwise></piecewise>"
)
_CUBIC = _apply("times", _ci("v"), _apply("minus", _cn(1), _ci("v")), _apply("minus", _ci("v"), _ci("a")))
_RECOVERY = _apply("minus", _apply("divide", _ci("v"), _cn(2)), _ci("w"))
#: FitzHugh and Nagumo, v′ = v (1 − v)(v − a) − w + stimulus, w′ = ε (v/2 − w), time in ms.
CELLML = f"""<?xml version="1.0"?>
<model xmlns="http://www.cellml.org/cellml/1.0#" xmlns:cellml="http://www.cellml.org/cellml/1.0#" name="fhn">
<units name="ms"><unit units="second" prefix="milli"/></units>
<component name="cell">
{_variable("time", units="ms")}{_variable("v", 0)}{_variable("w", 0.01)}{_variable("a", 0.13)}
{_variable("eps", 0.02)}{_variable("amplitude_of_stimulus", 0.4)}{_variable("i_stim")}{_variable("cubic")}
<math xmlns="http://www.w3.org/1998/Math/MathML">
{_mathml("i_stim", _STIMULUS)}
{_mathml("cubic", _CUBIC)}
{_mathml("v", _apply("plus", _apply("minus", _ci("cubic"), _ci("w")), _ci("i_stim")), rate=True)}
{_mathml("w", _apply("times", _ci("eps"), _RECOVERY), rate=True)}
</math></component></model>
"""


def cellml_in_python(v, w):
    """Rates of the model above, by name."""
    return {"cell.v": v * (1 - v) * (v - 0.13) - w, "cell.w": 0.02 * (v / 2 - w)}
