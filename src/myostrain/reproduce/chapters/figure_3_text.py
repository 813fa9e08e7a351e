"""What the chapter on figure 3 says: texts around measured numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myostrain.reproduce.content import Difference
from myostrain.reproduce.page import number

#: Runs of the first table and what they are called.
ROWS = {
    "rigid": "rigid",
    "stress": "plane stress",
    "strain": "plane strain",
    "rigid ratio 4": "rigid, ratio 4",
    "stress ratio 4": "plane stress, ratio 4",
    "strain ratio 4": "plane strain, ratio 4",
    "stress elastic": "plane stress, det Fe = 1",
    "strain elastic": "plane strain, det Fe = 1",
}

#: Runs in one dimension.
LINES = {
    "line rigid": "line, rigid",
    "line": "line, coupled (4.6)",
    "strip rigid": "strip, rigid",
    "strip stress": "free strip, plane stress",
    "strip strain": "free strip, plane strain",
}


def percent(ratio: float) -> str:
    """How much more than one, in percent: "+9.0 %"."""
    return f"{100 * (ratio - 1):+.1f} %".replace("-", "−")


class Words:
    """The texts.

    Args:
        numbers: What the chapter measured.
        quick: Whether at the quick settings.
    """

    def __init__(self, numbers: Mapping[str, Any], quick: bool) -> None:
        self._n, self._runs, self._quick = numbers, numbers["runs"], quick

    def _grid(self, *names: str, every: bool = True) -> str:
        """Mesh and step of runs, in words; the first one's mesh."""
        run = self._runs[names[0]]
        return f"{run['nodes']:,} nodes, {run['cells']:,} triangles, time step {run['step']:g}"

    @property
    def _settings(self) -> str:
        same = "mechanics every 4th step, in plane strain with J = 1 every 10th"
        return f"{self._grid('stress')}; {same}"

    @property
    def _fine_settings(self) -> str:
        return (
            f"{self._grid('stress ratio 4')}; mechanics every 4th (plane stress) and 10th step (plane strain)"
        )

    def introduction(self) -> str:
        """The introduction."""
        accuracy = (
            "These are the quick settings: celerities are within about 1 % of those at the full ones, those "
            "across the fibres at ratio 4, where fronts are half as thick, within 8 %."
            if self._quick
            else "These are the full settings; the last table says by how much a finer mesh and a smaller step "
            "change the numbers."
        )
        return (
            "A sheet, stretched out over an egg that touches the sides of a rectangle of 130 × 180, contracts "
            "along fibres in direction $(1,-1)$; elastic surroundings hold its edge, "
            "$\\mathbf{P N} = -k \\mathbf{u}$ (7.8). A bump of the potential, 0.9 within a radius of 8 at the "
            "bottom right, starts a pulse. Figure 3 shows the potential and the trace of the Cauchy stress on "
            "the deformed body at the time 3.\n\n"
            "“The vertical component of the strain plays the role of a diagnostic variable”: we take the sheet "
            "in **plane stress**, with free faces, $\\lambda_3 = 1/\\det \\mathbf{F}$, so that the pressure is "
            "eliminated and linear triangles do. Beside it stands **plane strain**, $\\det \\mathbf{F} = 1$ in the "
            "plane with the pressure of (7.5) as an unknown (quadratic displacement, linear pressure), which is "
            "what (7.5) says if its $\\mathbf{F}$ is taken literally as plane. The potential is (7.2), linear "
            "triangles, second order in time. The size of the bump, its place and the shape of the egg are ours, "
            "as the paper prints none of them.\n\n"
            f"Unless said otherwise: {self._settings}; for $\\mathbf{{D}}$ with ratio 4: {self._fine_settings}. "
            f"{accuracy}\n\n"
            "No number and no colour scale of figure 3 is in the text that we work from, so pictures are "
            "compared in words alone; what is judged below are the sentences of section 7, and those of "
            "sections 1, 3, 6 and 8 that speak of more than a line."
        )

    def measured(self) -> dict[str, str]:
        """What was measured, by claim."""
        n, runs, c = self._n, self._runs, self._n["celerity"]
        mesh, start, like, iso = n["mesh"], n["start"], n["like_1d"], n["isotropy"]
        stress, strain = c["stress"], c["strain"]
        near = {k: runs[k]["relevance"]["tenth"] for k in ("stress", "strain")}
        weak, J = n["weak_form"], n["constraint"]
        line, strip = like["coupled line (4.6)"], like["plane stress, free strip"]
        strip_strain, fixed = like["plane strain, free strip"], like["rigid sheet, rigid line"]
        large = {k: runs[k]["largest"] for k in ("stress", "strain")}
        return {
            "mesh": f"Our mesh of `sheet-2d` has {mesh['nodes']:,} nodes and {mesh['triangles']:,} triangles, whose "
            f"sides are {mesh['edge']:.2f} long on average; the egg's area is {mesh['area']:,.0f}. (The “Δx = 1” of "
            f"the same paragraph would need about {mesh['area']:,.0f} nodes on it, one for each unit of area.)",
            "few-steps": "The area where $v > 0.5$ grows for good from "
            f"t = {number(start['grows'])} on and has doubled at t = {start['doubled']:.2f}: the front leaves at "
            f"once. The back comes when the middle of the bump falls through 0.5 again, at t = {start['back']:.3f}: "
            "that is a fifth of the time that figure 3 takes, hundreds of steps of a size that resolves a front. "
            f"Time step 0.002, plane stress, {self._grid('stress').split(', time')[0]}.",
            "like-one-dimension": "At the sheet's centre (plane stress) the pulse has the maximum "
            f"{runs['stress']['pulses']['centre']['maximum']:.3f}, the minimum "
            f"{number(runs['stress']['pulses']['centre']['minimum'])} and the duration "
            f"{runs['stress']['pulses']['centre']['duration']:.3f}. On the coupled line of section 4 the duration "
            f"is {1 / line['duration']:.2f} times, the celerity {1 / line['celerity']:.2f} times that of the sheet. "
            "But the line is a continuum without a transverse direction, where $J \\ne 1$; on a free strip with "
            f"the sheet's own equations the ratios sheet to strip are {strip['duration']:.3f} (duration) and "
            f"{strip['celerity']:.3f} (celerity) in plane stress, {strip_strain['duration']:.3f} and "
            f"{strip_strain['celerity']:.3f} in plane strain, and on the rigid line {fixed['duration']:.3f} and "
            f"{fixed['celerity']:.3f}. The sheet's front is curved, and its surroundings hinder its contraction.",
            "isotropy-potential": "With diffusivities 100 along and 25 across the fibres, largest and smallest $v$ at "
            f"four probes change by at most {100 * iso['stress']['height']:.1f} % of the pulse's height, durations "
            f"by {100 * iso['stress']['duration']:.1f} % (plane stress; plane strain: "
            f"{100 * iso['strain']['height']:.1f} % and {100 * iso['strain']['duration']:.1f} %; rigid: "
            f"{100 * iso['rigid']['height']:.1f} % and {100 * iso['rigid']['duration']:.1f} %).",
            "isotropy-mechanics": "Over all times, ratio 4 changes the largest displacement by "
            f"{percent(iso['stress']['displacement'])}, the largest strain by {percent(iso['stress']['strain'])} and "
            f"the range of tr σ by {percent(iso['stress']['stress'])} in plane stress "
            f"({percent(iso['strain']['displacement'])}, {percent(iso['strain']['strain'])} and "
            f"{percent(iso['strain']['stress'])} in plane strain). The pulse is narrower across the fibres and its "
            "front is an ellipse, so that another part of the body contracts at a time.",
            "half": "With ratio 4, celerities across over along the fibres, fitted to the activation times of all "
            f"triangles away from bump and edge: {c['stress ratio 4']['ratio']:.3f} (plane stress), "
            f"{c['strain ratio 4']['ratio']:.3f} (plane strain), {c['rigid ratio 4']['ratio']:.3f} (rigid). "
            "On the rigid body one half is exact for plane fronts; the excess is the mesh's, as fronts across the "
            "fibres are only half as thick. Coupling lowers the ratio.",
            "faster-along": f"From 30 to 90 away from the bump's middle, along the fibres, the celerity is "
            f"{stress['along']:.2f} in plane stress and {strain['along']:.2f} in plane strain, against "
            f"{c['rigid']:.2f} on the rigid body: {percent(stress['along_ratio'])} and "
            f"{percent(strain['along_ratio'])}. A fit to all activation times gives "
            f"{percent(stress['along_ratio_fitted'])} and {percent(strain['along_ratio_fitted'])}.",
            "faster-across": "With the fibres turned by 90 degrees, along $(1, 1)$, the same path leads across them. "
            f"There the celerity is {stress['across']:.2f} in plane stress and {strain['across']:.2f} in plane strain, "
            f"against {c['rigid']:.2f} on the rigid body: {percent(stress['across_ratio'])} and "
            f"{percent(strain['across_ratio'])} (fitted to the body with unturned fibres: "
            f"{percent(stress['across_ratio_fitted'])} and {percent(strain['across_ratio_fitted'])}). What is "
            "shortened along the fibres is stretched across them, because it is incompressible, and there the "
            "front has farther to go.",
            "steeper": "Median of |Grad v| at v = 0.5 in fronts that go along the fibres, over that on the rigid "
            f"body: {stress['steepness_ratio_X']:.3f} in plane stress, {strain['steepness_ratio_X']:.3f} in plane "
            f"strain per material length; {stress['steepness_ratio_x']:.3f} and {strain['steepness_ratio_x']:.3f} "
            "per spatial length. With $J = 1$ the only feedback is the larger pulled-back diffusion, which makes "
            "a front faster and wider in $X$; that the line's front (4.9) is steeper comes from its $J \\ne 1$.",
            "fixed-domain": "At t = 3 the relative mean-square difference between the potential on the rigid body "
            f"and the coupled one is {n['fixed_domain']['stress']:.2f} in plane stress and "
            f"{n['fixed_domain']['strain']:.2f} in plane strain: the fronts are "
            f"{3 * (stress['along'] - c['rigid']):.0f} and {3 * (strain['along'] - c['rigid']):.0f} apart, if they "
            "travel along the fibres, and the pulse is about 17 long.",
            "relevant-displacement": f"At t = 3 the pulse, |v| > 0.1, takes {100 * near['stress']['area']:.0f} % of "
            f"the body (plane stress). There lie {100 * near['stress']['displacement_share']:.0f} % of ∫|u|² and "
            f"{100 * near['stress']['strain_share']:.0f} % of ∫|E|² (plane strain: "
            f"{100 * near['strain']['displacement_share']:.0f} % and {100 * near['strain']['strain_share']:.0f} %). "
            f"Elsewhere, |u| is on average {near['stress']['displacement']:.2f} and |E| "
            f"{near['stress']['strain']:.2f} times what it is in the pulse. So the strain is concentrated there, "
            "though not confined to it, and the displacement, which equilibrium carries on, is less so.",
            "fibres-contract": "Where $v > 0.5$ at t = 3, mean stretches along the fibres, across them and of the "
            f"plane's area: {_stretches(runs['stress'])} in plane stress and {_stretches(runs['strain'])} in plane "
            "strain. A free piece with $v = 0.86$ would shorten to 0.82 in plane stress, 0.86 in plane strain: the "
            "surroundings, at rest, resist.",
            "incompressible": "With J = 1 the volume at t = 3 changes by "
            f"{_scientific(J['stress']['volume_J'])} in plane stress, where it is exact by elimination, and by "
            f"{_scientific(J['strain']['volume_J'])} in plane strain, where the pressure keeps it (at worst "
            f"{100 * J['strain']['worst_triangle_J']:.2f} % in the mean over a triangle). With $\\det \\mathbf{{F}}_e = "
            f"1$ it changes by {number(100 * J['stress']['volume_Fe'])} % and {number(100 * J['strain']['volume_Fe'])} % "
            f"(−β times the mean of $v$ is {number(100 * J['stress']['volume_Fe_wanted'])} % and "
            f"{number(100 * J['strain']['volume_Fe_wanted'])} %), and the celerity along the fibres by "
            f"{percent(J['stress']['celerity_ratio'])} and {percent(J['strain']['celerity_ratio'])}; the largest "
            f"displacement is {runs['stress elastic']['largest']['displacement']:.2f} in place of "
            f"{large['stress']['displacement']:.2f}, and {runs['strain elastic']['largest']['displacement']:.2f} in "
            f"place of {large['strain']['displacement']:.2f}.",
            "weak-form": "Growth rates by linearisation at rest: as printed, a uniform disturbance grows at "
            f"{weak['printed']['uniform']:.2f} (the sign of $w$) and a wave of length 10 at "
            f"{weak['printed']['wave']:.0f} (the sign of the diffusion; shorter waves faster, without bound). With "
            f"the signs of (7.2) the rates are {number(weak['signs of (7.2)']['uniform'])} and "
            f"{number(weak['signs of (7.2)']['wave'])}.",
        }

    def table_runs(self) -> str:
        """Caption of the table of sheets."""
        return (
            "Sheets. “Along” and “across”: celerities with respect to the fibres, fitted to activation times "
            "up to t = 3; pulse at the centre (65, 90); largest displacement |u| and the range of the trace of the "
            "Cauchy stress over all times (the outermost 0.2 % of the area left out); volume and area of the body "
            f"at t = 3 against the reference. {self._settings}; ratio 4: {self._fine_settings}."
        )

    def table_lines(self) -> str:
        """Caption of the table of lines."""
        step = self._runs["strip stress"]["step"]
        return (
            "In one dimension, pulse at X = 60, celerity from 60 to 120. Lines: Δx = 1, Δt = 0.003 (section 4). "
            f"Strips: 160 × 2 with free edges, fibres along it, Δx = 1, Δt = {step:g}, the equations of section 7."
        )

    def table_convergence(self) -> str:
        """Caption of the table of convergence."""
        finer = self._grid("stress finer")
        return f"What changes, in percent, from {finer} to this chapter's settings ({self._settings})."

    def caption(self, picture: str) -> str:
        """Caption of a picture."""
        end = "t = 3, the grey outline is the reference body"
        captions = {
            "figure-3": "Our figure 3: potential $v$ (the paper's panel a) and trace of the Cauchy stress (b) on the "
            f"deformed body, {end}. As the paper describes it, a curved pulse crosses the body from the bottom right. "
            "(The grey outline hardly shows: the edge moves by less than the interior, which moves by up to "
            f"{self._runs['stress']['largest']['displacement']:.1f}.) Where the front goes along the fibres, on the "
            "left, the active band is hindered from widening sideways, and compressed; where it goes across them, "
            "on the right, it is hindered from shortening along itself, and pulled. "
            f"{self._settings}.",
            "ratio-4": f"The same with diffusivities 100 along and 25 across the fibres: {end}. {self._fine_settings}.",
            "elastic": f"The same with $\\det \\mathbf{{F}}_e = 1$ (Cherubini et al.) in place of $J = 1$: {end}. "
            f"{self._settings}.",
            "isochrones": "Activation times (v = 0.5) on the reference body, white lines every 0.25; white areas are "
            f"not reached by t = 3. Coupled: plane stress. {self._settings}; ratio 4: {self._fine_settings}.",
            "relevance": "Where the body is displaced and where it is strained, plane stress, t = 3. The blue lines "
            f"are v = 0.1 and v = −0.1. {self._settings}.",
            "pulses": "Potential at the sheet's centre (65, 90), and at X = 60 on the lines of section 4, against "
            f"the time since it rose through 0.5. Sheets: {self._settings}. Lines: Δx = 1, Δt = 0.003.",
        }
        return captions[picture]

    def differences(self) -> list[Difference]:
        """For the authors' eyes."""
        n, c = self._n, self._n["celerity"]
        near, weak = self._runs["stress"]["relevance"]["tenth"], n["weak_form"]
        path = "'probes={a=[73.787, 46.213], b=[31.36, 88.64]}'"
        return [
            Difference(
                "Signs in the weak form (7.6)",
                "Multiplying (7.2) by a test function gives $+D \\int \\mathbf{F}^{-T} \\nabla v \\cdot \\mathbf{F}^{-T} "
                "\\nabla \\phi$ on the left and $-A \\int (v(v-\\alpha)(v-1) + w) \\phi$ on the right; (7.6) has a minus "
                "before the diffusion and before $w$. With these signs rest is unstable: growth rates "
                f"{weak['printed']['uniform']:.2f} (uniform) and {weak['printed']['wave']:.0f} (wavelength 10). We take "
                "both for slips of the pen and solve (7.2). The command runs (7.2).",
                "myostrain run sheet-2d --set geometry.spacing=2.4 --set time.end=1.0",
            ),
            Difference(
                "What is along the fibres, after (7.4)",
                "After (7.4) “it has been assumed that diffusion occurs along the fibers' direction only”; on the next "
                "page “the active strain is oriented along the fibers, while the diffusion is isotropic”. As (7.4) "
                "holds no diffusion, but an active strain along the fibres only, we read the first sentence as one on "
                "the active strain, and take $\\mathbf{D}$ isotropic in figure 3. We also take $\\mathbf{n}$ as the unit "
                "vector of (1.4): with the printed $(1,-1)$ put into (7.4) as it stands, the contraction would be "
                "doubled. The command runs the other extreme that the paper names, ratio 4.",
                "myostrain run sheet-2d --set 'potential.diffusivity=[100.0, 25.0]'",
            ),
            Difference(
                "Coupled fronts are slower across the fibres (section 8)",
                "Section 8 says that celerities are generally bigger than on rigid substrates. In the plane that holds "
                f"along the fibres, {percent(c['stress']['along_ratio'])} (plane stress) and "
                f"{percent(c['strain']['along_ratio'])} (plane strain), but across them the front is slower by "
                f"{100 * (1 - c['stress']['across_ratio']):.1f} % and {100 * (1 - c['strain']['across_ratio']):.1f} %: "
                "incompressible tissue that shortens along the fibres lengthens across them. The command turns the "
                f"fibres, so that the probes lie across them; its celerity is to be compared with {c['rigid']:.1f} "
                "for the rigid body (add `--set 'mechanics.imposed_stretch={value=1.0, until=inf}'`).",
                f"myostrain run sheet-2d --set 'fibres.direction=[1.0, 1.0]' --set {path}",
            ),
            Difference(
                "Fronts on the sheet are not steeper in material coordinates (section 8)",
                "With $J = 1$, (7.2) has no factor $J$ in front of its time derivative and reaction; the coupling only "
                "enlarges the diffusion along the contracted fibres. Such a front is faster and, in $X$, wider: its "
                f"slope along the fibres is {c['stress']['steepness_ratio_X']:.3f} (plane stress) and "
                f"{c['strain']['steepness_ratio_X']:.3f} (plane strain) times the rigid one; in spatial coordinates it "
                f"is {c['stress']['steepness_ratio_x']:.3f} and {c['strain']['steepness_ratio_x']:.3f} times. The "
                "steeper front of (4.10) belongs to the line, whose volume changes.",
                "myostrain reproduce figure-3",
            ),
            Difference(
                "Displacement away from the pulse (section 7)",
                "“The displacement of the substrate is relevant only where the action potential pulse is not small”: "
                f"at t = 3, where |v| ≤ 0.1, |u| is on average {near['displacement']:.2f} times what it is in the pulse, "
                f"and {100 * (1 - near['displacement_share']):.0f} % of ∫|u|² lie there. Equilibrium is not local: a "
                "contracting band pulls its surroundings along, over the length that the support (7.8) sets. The "
                f"strain is nearer to the sentence, {100 * (1 - near['strain_share']):.0f} % of ∫|E|².",
                "myostrain reproduce figure-3 --quick",
            ),
            Difference(
                "More than the velocity differs with anisotropic diffusion (section 7)",
                "The potential's pulse is the same, but the body is strained in another way, as the pulse is narrower "
                "across the fibres: over all times, ratio 4 changes the largest displacement by "
                f"{percent(n['isotropy']['stress']['displacement'])} and the range of tr σ by "
                f"{percent(n['isotropy']['stress']['stress'])} (plane stress).",
                "myostrain reproduce figure-3",
            ),
        ]

    def remarks(self) -> str:
        """What else was seen."""
        circular = self._n["circular"]
        return (
            "“The curvature of the front is due to non-Cartesian geometry of the domain and the almost pointwise "
            "initial conditions.” On the rigid body the activation time is a function of the distance from the "
            f"bump's middle to {100 * circular:.1f} % (root mean square, relative to the latest arrival): fronts are "
            "circles around the bump, so it is the initial condition that curves them; the edge of a convex body "
            "only bends their ends. With coupling or ratio 4 they become ovals. There is no number in the "
            "paper to judge this by.\n\n"
            "Plane stress and plane strain differ most in the stress: between rigid plates a pressure carries part "
            "of what free faces let go, so that plane strain shows more compression, a smaller displacement and a "
            "smaller gain in celerity. Which of the two made figure 3, its text does not say."
        )


def _stretches(run: Mapping[str, Any]) -> str:
    stretch = run["stretch"]
    return f"{stretch['fibre']:.3f}, {stretch['cross']:.3f} and {stretch['area']:.3f}"


def _scientific(value: float) -> str:
    return "less than 10⁻¹⁵" if abs(value) < 1e-15 else number(value)
