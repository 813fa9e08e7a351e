"""Active strain and active stress on one mesh, with one passive material: they contract, then are pulled."""

import myostrain as ms

body = ms.build(ms.geometry.Slab(size=(2, 1, 1)), ms.UniformFibres(direction=(1, 0, 0)))
drive = ms.GivenPotential(body, ms.Drive(potential=((0, 0), (1, 1))))  # from 0 to 1, then 1
activations = {  # a law, and what it does
    "active strain": (ms.activation.Proportional(beta=0.15), ms.activation.Fibre()),
    "active stress": (ms.activation.ActiveStress(tension=2.83), ms.activation.FibreTension()),  # kPa
}
stretches = {}
for name, (law, active) in activations.items():
    mechanics = ms.Mechanics(
        body,
        kinematics=ms.kinematics.Solid(),
        material=ms.materials.Guccione1995(),
        active=active,
        supports=ms.Supports(sliding=["left", "front", "bottom"]),
        # A pull of up to 5 kPa, after the contraction.
        loads=ms.Loads(pressure={"right": ((1, 0), (2, -5))}),
    )
    model = ms.Electromechanics(drive, mechanics, law=law, scheme=ms.Implicit())
    metrics = ms.Simulation(model, step=0.25, end=2.0).run()["metrics"]
    stretches[name] = 1 - metrics["fibre_shortening"], metrics["fibre_stretch_mean"]
    print("{}: stretch {:.4f} when free, {:.4f} when pulled".format(name, *stretches[name]))
