"""An electrical pulse crosses a contracting sheet: the paper's figure 3, on a coarser mesh."""

import myostrain as ms

shape = ms.geometry.Ellipse(size=(130, 180), spacing=2.0, distortion=0.15)
body = ms.build(shape, ms.UniformFibres(direction=(1, -1)))
mechanics = ms.Mechanics(
    body,
    kinematics=ms.kinematics.PlaneStress(),
    material=ms.materials.NeoHookean(mu=1.0),
    supports=ms.Supports(robin=1.0),  # elastic support of the boundary
)
cell = ms.membranes.FitzHughNagumo(alpha=0.1, tau=0.2, A=100.0)
start = ms.InitialValues(where=ms.Place(center=(95, 25), radius=8), potential=0.9)
parts = dict(mass="averaged", deformation=mechanics.deformation, initial=[start])
potential = ms.Potential(body, membrane=cell, diffusivity=100.0, **parts)
law = ms.activation.Proportional(beta=0.3)
model = ms.Electromechanics(potential, mechanics, law=law, scheme=ms.SecondOrder(every=4))
probes = {"near": (80, 50), "far": (50, 130)}
results = ms.Simulation(model, step=3e-3, end=3.0, probes=probes, out="runs/sheet", force=True).run()
print(results["metrics"])
