"""Which PETSc options a case file or a script may set, and with what values.

PETSc has thousands, of which many print, write files anywhere, load code or end the process. What is listed
here chooses and tunes linear solvers; the list is of PETSc 3.25.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from myostrain.errors import InputError, dotted, nearest, shown


@dataclass(frozen=True)
class Number:
    """A finite number."""

    low: float = -math.inf
    whole: bool = False
    several: int = 1

    def refusal(self, value: Any) -> str | None:
        """What is wrong with a value; None if nothing."""
        parts = value.split(",") if isinstance(value, str) else [value]
        if isinstance(value, bool) or len(parts) > self.several or not all(map(self._fits, parts)):
            kind = "an integer below 2^31" if self.whole else "a finite number"
            least = "" if self.low == -math.inf else f", at least {self.low:g}"
            more = f', or up to {self.several} as a text, such as "0.1,0.2"' if self.several > 1 else ""
            return f"give {kind}{least}{more}"
        return None

    def _fits(self, part: Any) -> bool:
        try:
            number = float(part)
        except (ValueError, TypeError, OverflowError):
            return False
        whole = number.is_integer() and abs(number) < 2**31 and "." not in str(part)
        return math.isfinite(number) and number >= self.low and (whole or not self.whole)


@dataclass(frozen=True)
class Word:
    """One of some words."""

    words: tuple[str, ...]

    def refusal(self, value: Any) -> str | None:
        """What is wrong with a value; None if nothing."""
        if isinstance(value, str) and value in self.words:
            return None
        return nearest(value, self.words) if isinstance(value, str) else f"known: {', '.join(self.words)}"


class Switch:
    """True or false."""

    def refusal(self, value: Any) -> str | None:
        """What is wrong with a value; None if nothing."""
        return None if isinstance(value, bool) or value in ("true", "false") else "give true or false"


class Printed:
    """Something that PETSc prints on the terminal: true, and no word, which would name a file."""

    def refusal(self, value: Any) -> str | None:
        """What is wrong with a value; None if nothing."""
        return None if value is True else "give true: it is printed, not written to a file"


_number, _integer, _switch, _printed = Number(), Number(whole=True), Switch(), Printed()
_positive, _count, _counts = Number(low=0.0), Number(low=0, whole=True), Number(low=0.0, several=10)


def _word(text: str) -> Word:
    return Word(tuple(text.split()))


#: Options by name, without the words that reach a part of a solver.
ALLOWED: Mapping[str, Number | Word | Switch | Printed] = {
    "ksp_type": _word(
        "bcgs bcgsl bicg cg cgs chebyshev cr fbcgs fcg fgmres gcr gmres ibcgs lgmres minres pgmres pipecg "
        "pipecr preonly richardson symmlq tfqmr"
    ),
    "ksp_rtol": _positive,
    "ksp_atol": _positive,
    "ksp_divtol": _positive,
    "ksp_max_it": _count,
    "ksp_min_it": _count,
    "ksp_pc_side": _word("left right symmetric"),
    "ksp_norm_type": _word("none preconditioned unpreconditioned natural"),
    "ksp_initial_guess_nonzero": _switch,
    "ksp_error_if_not_converged": _switch,
    "ksp_gmres_restart": _count,
    "ksp_gmres_modifiedgramschmidt": _switch,
    "ksp_gmres_cgs_refinement_type": _word("refine_never refine_ifneeded refine_always"),
    "ksp_lgmres_augment": _count,
    "ksp_gcr_restart": _count,
    "ksp_bcgsl_ell": _count,
    "ksp_richardson_scale": _number,
    "ksp_richardson_self_scale": _switch,
    "ksp_chebyshev_eigenvalues": _counts,
    "ksp_chebyshev_esteig": _counts,
    "ksp_chebyshev_esteig_steps": _count,
    "ksp_chebyshev_kind": _word("first fourth opt_fourth"),
    "ksp_monitor": _printed,
    "ksp_monitor_true_residual": _printed,
    "ksp_converged_reason": _printed,
    "ksp_view": _printed,
    "pc_type": _word(
        "asm bjacobi cholesky eisenstat fieldsplit gamg hypre icc ilu jacobi lu none pbjacobi redundant sor "
        "vpbjacobi"
    ),
    "pc_precision": _word("single double"),
    "pc_factor_levels": _count,
    "pc_factor_fill": _positive,
    "pc_factor_mat_solver_type": _word("petsc mumps superlu superlu_dist umfpack cholmod klu"),
    "pc_factor_mat_ordering_type": _word("natural nd 1wd rcm qmd rowlength amd metisnd external"),
    "pc_factor_shift_type": _word("none nonzero positive_definite inblocks"),
    "pc_factor_shift_amount": _positive,
    "pc_factor_zeropivot": _positive,
    "pc_factor_reuse_ordering": _switch,
    "pc_factor_reuse_fill": _switch,
    "pc_factor_pivot_in_blocks": _switch,
    "pc_factor_nonzeros_along_diagonal": _positive,
    "pc_jacobi_type": _word("diagonal rowmax rowl1 rowsum"),
    "pc_jacobi_abs": _switch,
    "pc_sor_omega": _positive,
    "pc_sor_its": _count,
    "pc_sor_lits": _count,
    "pc_sor_symmetric": _switch,
    "pc_sor_local_symmetric": _switch,
    "pc_bjacobi_blocks": _count,
    "pc_bjacobi_local_blocks": _count,
    "pc_asm_overlap": _count,
    "pc_asm_blocks": _count,
    "pc_asm_type": _word("basic restrict interpolate none"),
    "pc_gamg_type": _word("agg classical"),
    "pc_gamg_threshold": Number(several=10),
    "pc_gamg_threshold_scale": _number,
    "pc_gamg_agg_nsmooths": _count,
    "pc_gamg_aggressive_coarsening": _count,
    "pc_gamg_aggressive_square_graph": _switch,
    "pc_gamg_coarse_eq_limit": _count,
    "pc_gamg_process_eq_limit": _count,
    "pc_gamg_repartition": _switch,
    "pc_gamg_reuse_interpolation": _switch,
    "pc_gamg_asm_use_agg": _switch,
    "pc_gamg_recompute_esteig": _switch,
    "pc_gamg_use_sa_esteig": _switch,
    "pc_mg_levels": _count,
    "pc_mg_type": _word("multiplicative additive full kaskade"),
    "pc_mg_cycle_type": _word("v w"),
    "pc_mg_multiplicative_cycles": _count,
    "pc_mg_distinct_smoothup": _switch,
    "pc_fieldsplit_type": _word("additive multiplicative symmetric_multiplicative schur"),
    "pc_fieldsplit_schur_fact_type": _word("diag lower upper full"),
    "pc_fieldsplit_schur_precondition": _word("self selfp a11 full"),
    "pc_hypre_type": _word("boomeramg euclid parasails pilut"),
    "pc_hypre_boomeramg_strong_threshold": _positive,
    "pc_hypre_boomeramg_max_iter": _count,
    "pc_hypre_boomeramg_max_levels": _count,
    # MUMPS: neither its printing (ICNTL 1 to 4) nor factors on the disk (22) or a saved problem.
    **{f"mat_mumps_icntl_{n}": _integer for n in (6, 7, 8, 10, 12, 13, 14, 23, 24, 27, 28, 29, 35, 36, 38)},
    **{f"mat_mumps_cntl_{n}": _number for n in (1, 2, 3, 4, 5, 7)},
}

#: Words before an option that reach a part of a solver: blocks, fields, levels.
_PART = re.compile(r"sub_|fieldsplit_[up]_|mg_levels_(?:\d+_)?|mg_coarse_(?:sub_)?|redundant_|esteig_")


def _bare(name: str) -> str:
    """A name without the words that reach a part of a solver."""
    while found := _PART.match(name):
        name = name[found.end() :]
    return name


def check_option(name: str, value: Any) -> str | None:
    """What is wrong with a PETSc option.

    Args:
        name: Its name, without a prefix of the solver.
        value: Its value; None for an option without one.

    Returns:
        A sentence that says what is allowed; None if nothing is wrong.
    """
    bare = _bare(name)
    if bare not in ALLOWED:
        if not bare.startswith(("ksp_", "pc_", "mat_")):
            return "no option of a linear solver: they begin with ksp_, pc_ or mat_"
        close = nearest(bare[:100], ALLOWED).partition("? (known")[0]
        hint = f"{close}?" if close.startswith("did") else "see PETSc's manual for those of ksp_ and pc_"
        return f"no option that may be set here (it is unknown, or prints, runs code or uses files); {hint}"
    return ALLOWED[bare].refusal(value)


def check_options(name: str, options: Mapping[str, Any] | None) -> None:
    """Refuse PETSc options that may not be set, or not to these values.

    Args:
        name: "mechanics" or "potential".
        options: The options; None for none.

    Raises:
        InputError: One may not be; it is named.
    """
    for key, value in (options or {}).items():
        if problem := check_option(str(key), value):
            raise InputError(f"{problem}, not {shown(value)}", dotted("solver", name, str(key)))


def without_viewers(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """The options as PETSc takes them: what is printed has no value, which would name a viewer."""
    printed = {key for key in options or {} if isinstance(ALLOWED.get(_bare(key)), Printed)}
    return {key: None if key in printed else value for key, value in (options or {}).items()}
