"""Hard cases with a metric and a bound each; `stress` runs them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from symdyn.bench.measurements import Case, Stress
from symdyn.bench.stress import motions, odd_numbers as numbers, solving
from symdyn.errors import DerivationError, MethodError, MissingProgram, SimulateError
from symdyn.frozen import dataclass, replace
from symdyn.scene import Scene
from symdyn.verdict import Unclaimed


@dataclass(frozen=True)
class Family:
    """Cases of one kind.

    Attributes:
        text: what they are about.
        builtin: yields those of the built-in scenes, and what this machine cannot run of them.
        of_scene: yields those of a user's scene, None where there are none.
    """

    text: str
    builtin: Callable[[], Iterator[Case | Unclaimed]]
    of_scene: Callable[[Scene], Iterator[Case | Unclaimed]] | None = None


FAMILIES: Mapping[str, Family] = {
    "solving": Family("near-singular mass matrices, mass ratios, gimbal lock", solving.builtin, solving.of_scene),
    "chains": Family("chains of up to 100 links in relative and absolute angles", solving.chains),
    "angles": Family("huge and tiny angles, sums of angles", solving.huge_angles, solving.angles_of_scene),
    "numbers": Family("NaN, infinities, denormals, -0, float, hardly any mechanism", numbers.builtin, numbers.of_scene),
    "traps": Family("floating-point exceptions", numbers.traps, numbers.traps_of_scene),
    "spin": Family("fast spin: heavy top, middle axis", motions.spin),
    "stiff": Family("stiff springs", motions.stiff),
    "loops": Family("change points, redundant loops", motions.change_points),
    "chaos": Family("chaotic and long motions", motions.chaos, motions.chaos_of_scene),
}


def stress(
    scene: Scene | None = None,
    families: Sequence[str] | None = None,
    command: str = "",
    progress: Callable[[str], None] = lambda _: None,
) -> Stress:
    """Return the hard cases of the built-in scenes, or of a scene.

    Args:
        scene: None takes the built-in ones.
        families: keys of `FAMILIES`; None takes all.
        command: what runs it again, for reports.
        progress: takes what is being done.

    Raises:
        SimulateError: a family does not exist.
        BuildError: the compiler refuses.
    """
    from symdyn.errors import suggestion

    wanted = tuple(FAMILIES) if families is None else tuple(families)
    unknown = [f"family {name} is not known; {suggestion(name, FAMILIES)}" for name in wanted if name not in FAMILIES]
    if unknown:
        raise SimulateError(unknown)
    cases: list[Case] = []
    absent: list[Unclaimed] = []
    not_run: list[Unclaimed] = []
    unshown: list[Unclaimed] = []
    for name in wanted:
        family = FAMILIES[name]
        progress(family.text)
        cannot = not_run if families is None else unshown
        try:
            found = list(family.builtin() if scene is None else family.of_scene(scene) if family.of_scene else ())
        except DerivationError as fault:
            absent.append(Unclaimed(name, str(fault)))
            continue
        except (MissingProgram, MethodError) as fault:  # this machine lacks something
            cannot.append(Unclaimed(name, str(fault)))
            continue
        except SimulateError as fault:  # the scene has no value, or none that is real
            unshown.append(Unclaimed(name, str(fault)))
            continue
        cases += (replace(one, family=name) for one in found if isinstance(one, Case))
        cannot += (replace(one, what=f"{name}: {one.what}") for one in found if isinstance(one, Unclaimed))
        if family.of_scene is not None and not found:
            absent.append(Unclaimed(name, "no case is about such a scene"))
    of_built_in = [name for name in wanted if scene is not None and FAMILIES[name].of_scene is None]
    if of_built_in:
        absent.append(Unclaimed(", ".join(of_built_in), "all cases are about built-in scenes"))
    left = (tuple(absent), tuple(not_run), tuple(unshown))
    return Stress("" if scene is None else scene.name, command, tuple(cases), *left)
