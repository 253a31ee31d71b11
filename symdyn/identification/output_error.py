"""Output error: parameters and starts with which a simulated run is closest to what was measured: `output_error`.

    min  Σ ((x(t_k; p, x_0) - x_k) / σ)²        over named parameters p and the unknown start x_0 of every piece

Nothing is differentiated: a coordinate or velocity that was not measured is one that the run finds. The search is that
of Levenberg and Marquardt by the derivatives of the run itself; it looks at the first eighth of a piece, then at twice
as much, so that each search begins where the run stays close to the data. σ is the scatter of the residuals, found
again after every search (maximum likelihood with independent columns). Residuals whose samples are correlated, as of
coloured noise or noisy forces, are told in the errors:

    Cov = (J'J)^-1 J' S J (J'J)^-1     S of residuals as autoregressive columns whose innovations may be correlated

References: Ljung, System Identification (1999), 7.2 to 7.4, 9.4; Bock (1981); Burg (1975).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, with_fields
from symdyn.errors import IdentifyError, UnknownNameError, listed, suggestion
from symdyn.extras import package
from symdyn.frozen import dataclass, field, replace
from symdyn.identification.shooting import FEWEST, Measured, Search, first_state, read_measured, searched, shooting
from symdyn.rounding import in_digits
from symdyn.scene import Scene, SceneLike, SceneUnits, with_values
from symdyn.scene.values import Faults
from symdyn.shown import Shown
from symdyn.simulation import Problem, opened
from symdyn.simulation.prescribed import Entries, parameter_values
from symdyn.table import Table

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]


@dataclass(frozen=True, eq=False)
class OutputFit(Shown):
    """Parameters with which a simulated run is closest to measured columns.

    Attributes:
        declared: the mechanism, its parameters as they were.
        names: of what was estimated: parameters, then positions and velocities of the starts, `start x` or, of more
            than one piece, `start 2 x`.
        units: likewise.
        before: values that the scene gives, and guesses of starts, shape (k,).
        estimate: shape (k,).
        covariance: shape (k, k), from the scatter and the correlation of the residuals.
        parameters: how many of the names are parameters.
        measured: names of the columns that were fitted.
        noise: standard deviation of the residuals of each, shape (m,).
        correlation: of their residuals from one sample to the next, shape (m,).
        residuals: by piece of the log: simulated less measured, shape (N, m).
        t: by piece: times, s, shape (N,).
        condition: number of the weighted Jacobian, its columns scaled to length one.
        dof: samples less estimates.
        runs: how many runs were taken.
        notes: what a user should know.
    """

    declared: Scene
    names: tuple[str, ...]
    units: tuple[str, ...]
    before: Array = field(repr=False)
    estimate: Array = field(repr=False)
    covariance: Array = field(repr=False)
    parameters: int
    measured: tuple[str, ...]
    noise: Array = field(repr=False)
    correlation: Array = field(repr=False)
    residuals: tuple[Array, ...] = field(repr=False)
    t: tuple[Array, ...] = field(repr=False)
    condition: float
    dof: int
    runs: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        parts = zip(self.names[: self.parameters], self.estimate, self.standard_errors, strict=False)
        said = ", ".join(f"{name} = {value:.5g} ± {error:.2g}" for name, value, error in parts)
        doubt = "".join(f"; {a} and {b} hardly told apart (r = {r:.4f})" for a, b, r in self.alike[:1])
        return f"<OutputFit of {self.declared.name} to {listed(self.measured)}: {said}{doubt}>"

    def __getitem__(self, name: str) -> float:
        """Return an estimate by its name; UnknownNameError if there is none."""
        return float(self.estimate[self._place(name)])

    @property
    def standard_errors(self) -> Array:
        """Of every estimate, shape (k,)."""
        return np.sqrt(np.diag(self.covariance))

    errors = standard_errors

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Return the ends of an interval that holds the true value with a probability."""
        from scipy.stats import t

        k = self._place(name)
        reach = float(t.ppf(0.5 + level / 2, self.dof) * self.standard_errors[k])
        return float(self.estimate[k]) - reach, float(self.estimate[k]) + reach

    @property
    def alike(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of a parameter and another estimate whose errors have a correlation beyond ±0.99; the worst first."""
        r, named = self.covariance / np.outer(self.errors, self.errors).clip(1e-300), [*enumerate(self.names)]
        pairs = [(a, b, float(r[i, k])) for i, a in named[: self.parameters] for k, b in named[i + 1 :]]
        return tuple(sorted((one for one in pairs if abs(one[2]) > ALIKE), key=lambda one: -abs(one[2])))

    @property
    def values(self) -> Mapping[str, float]:
        """Estimates of parameters by name."""
        return dict(zip(self.names[: self.parameters], self.estimate.tolist(), strict=False))

    @property
    def scene(self) -> Scene:
        """The scene with the parameters that were found."""
        return with_values(self.declared, self.values)

    def table(self) -> Table[str]:
        """Return name, unit, before, after and standard error of every estimate."""
        columns = zip(self.names, self.units, self.before, self.estimate, self.standard_errors, strict=True)
        rows = [
            (name, unit, in_digits(before, 5), in_digits(after, 5), in_digits(error, 2))
            for name, unit, before, after, error in columns
        ]
        heads = ("parameter", "unit", "before", "after", "standard error")
        return Table(heads, rows, range(2, 5), f"parameters of {self.declared.name}")

    def to_pandas(self) -> pandas.DataFrame:
        """Return a row an estimate: its value, standard error, unit and value before, as `table` has them.

        Raises:
            IdentifyError: pandas is not installed.
        """
        pandas = package("pandas", IdentifyError, ".table()")
        columns = {"value": self.estimate, "standard_error": self.errors, "unit": [*self.units], "before": self.before}
        return pandas.DataFrame(columns, index=pandas.Index(self.names, name="parameter"))

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise UnknownNameError(f"{name} is not there; {suggestion(name, self.names)}")
        return self.names.index(name)


TELLS = 1e-7
"""Smallest singular value over the largest, columns of length one, below which a direction is not identifiable."""

POSITIVE = 1e-9
"""Least value of a positive parameter, over its value before."""

ROUNDING = 1e-9
"""Least weight of a column, over its scatter: simulated data have residuals of rounding."""

WHITE, FAR, ALIKE = 0.5, 3.0, 0.99
"""Correlation from sample to sample, residuals over the scatter of neighbouring samples, and correlation of the errors
of two estimates, that are worth a word."""


@with_fields(Problem)
def output_error(
    scene: SceneLike | Problem,
    data: Entries,
    parameters: str | Sequence[str] | None = None,
    measured: str | Sequence[str] | None = None,
    pieces: int = 1,
    say: Callable[[str], None] | None = None,
    **fields: Unpack[Problem.Fields],
) -> OutputFit:
    """Return the parameters with which simulated runs are closest to measured ones.

    >>> import symdyn
    >>> from symdyn.identification import output_error
    >>> truth = symdyn.simulate(symdyn.example("pendulum"), until=3, start={"q1": 1}, values={"l": 0.55, "b": 0.02})
    >>> output_error(symdyn.example("pendulum"), {"t": truth.t, "q1": truth["q1"]}, ["l", "b"]).values["l"].__round__(6)
    0.55

    Args:
        scene: the mechanism, its parameters bound: the search begins at their values; or a `Problem`.
        data: a .csv file, arrays by name, a table or a run, of columns t, coordinates, velocities, states and driving
            forces; or a list of such, one a log, each with a start of its own.
        parameters: names of those to estimate; None takes all identifiable ones but gravity's. Which they are
            not is reported.
        measured: which columns are fitted; None for all coordinates, velocities and states that the logs have.
        pieces: into how many pieces every log is cut, each with a start of its own: for motions that forget theirs.
        say: told after a minute, and then after four times as long, that the search goes on; a RuntimeWarning without.
        **fields: of `Problem`.
        forces: driving forces that the logs have no columns of, as `simulate` takes them.
        start: guesses of coordinates and states at the start that were not measured, by name.
        start_rates: likewise of velocities.

    Raises:
        SimulateError: with every fault of the arguments and the data, one line each.
        IdentifyError: parameters that are not identifiable, a motion that forgets its start, no run.
        DerivationError: there is no forward dynamics, or loops cannot be closed.
    """
    problem, _ = Problem.requested(output_error, locals())
    scene, guess = problem.scene, problem.by_name
    parameter_values(scene)
    faults, known = Faults(""), [one.name for one in scene.parameters]
    asked = None if parameters is None else (parameters,) if isinstance(parameters, str) else tuple(parameters)
    for name in (one for one in asked or () if one not in known):
        faults.add("parameters", f"{name} is not known; {suggestion(name, known)}")
    faults.close(IdentifyError)
    wanted = None if measured is None else (measured,) if isinstance(measured, str) else tuple(measured)
    names, logs, notes = read_measured(problem, data, wanted, pieces)
    if taken := [name for name in guess[0] if name in names]:
        left = {name: x for name, x in guess[0].items() if name not in taken} or None
        what = f"the log has {listed(taken)}, and every piece begins there: {'give' if left else 'leave out'}"
        raise IdentifyError(f"start: {what} {argument('start', left)}")
    down = {name for part in scene.gravity for name in part.symbols}
    free = tuple(one.name for one in opened(scene).scene.free_parameters if one.name not in down)
    chosen = tuple(dict.fromkeys(free if asked is None else asked))
    if not chosen:
        raise IdentifyError(
            f"{scene.name}: parameters: none is to be estimated; name one in [parameters], not gravity's, or all by "
            f"{argument('symbolic', 'all', 'symdyn.scene.with_symbols')}"
        )
    search, more = _begin(scene, names, logs, chosen, guess)
    if asked is None:
        told = _told(search)
        if held := [name for name in chosen if name not in told]:
            more = (*more, f"{listed(held)} kept as given: identifiable in combination with {listed(told)} only")
            search, _ = _begin(scene, names, logs, told, guess)
    positive = {one.name for one in scene.parameters if one.positive}
    least = np.full(len(search.before), -np.inf)
    least[: len(search.parameters)] = [POSITIVE if name in positive else -np.inf for name in search.parameters]
    begun, due = perf_counter(), [60.0]

    def look(runs: int) -> None:
        if (spent := perf_counter() - begun) >= due[0]:
            told, due[0] = f"{scene.name}: the search goes on after {spent:.0f} s, {runs} runs", 4 * spent
            (say or partial(warnings.warn, category=RuntimeWarning, stacklevel=2))(told)

    search.look = look
    return _found(scene, search, searched(search, least), names, (*notes, *more))


def _begin(
    scene: Scene,
    names: Sequence[str],
    logs: Sequence[Measured],
    parameters: tuple[str, ...],
    guess: tuple[dict[str, Any], dict[str, Any]],
) -> tuple[Search, tuple[str, ...]]:
    """Return the search where it begins, and notes."""
    known, pieces, notes = opened(scene).values, [], dict[str, None]()
    for one in logs:
        x, said = first_state(scene, names, one, guess)
        notes |= dict.fromkeys(said if len(logs) == 1 else ())
        pieces.append(shooting(scene, parameters, one.forces, one.t, x))
    starts = len(pieces[0].unknowns)
    sizes = np.array([abs(known[name]) or 1.0 for name in parameters])
    before = np.concatenate([[known[name] for name in parameters] / sizes, np.zeros(starts * len(pieces))])
    columns = [[*scene.coordinates, *scene.first_order].index(name) for name in names]
    scatter = np.concatenate([one.x for one in logs]).std(axis=0)
    scatter = np.where(scatter > 0, scatter, 1.0)
    found = Search(pieces, logs, columns, parameters, sizes, before, starts, scatter, ROUNDING * scatter)
    return found, tuple(notes)


def _told(search: Search) -> tuple[str, ...]:
    """Return a set of parameters that is identifiable, the best identifiable first, in the order given."""
    from scipy.linalg import qr

    n, whole = len(search.parameters), search.pieces
    for part in (1, 2, 4, 8):  # values that are far off may not have a run to the end
        search.pieces = [one.until(max(FEWEST, len(one.t) // part)) for one in whole]
        search.forget()
        if None not in search.run(search.before):
            break
    else:
        raise IdentifyError("there is no run at the values that the search begins with; give other ones")
    J = search.jacobian(search.before)
    search.pieces = whole
    search.forget()
    others, _ = np.linalg.qr(J[:, n:])
    own = J[:, :n] - others @ (others.T @ J[:, :n])
    R, order = qr(own, mode="r", pivoting=True)
    size = np.abs(np.diag(R))
    kept = {
        int(k) for k, one in zip(order, size, strict=False) if one > 10 * TELLS * np.linalg.norm(J[:, :n], axis=0).max()
    }
    if not kept:
        raise IdentifyError("no parameter is identifiable: nothing moves, or all columns are starts")
    return tuple(name for k, name in enumerate(search.parameters) if k in kept)


def _found(scene: Scene, search: Search, unknowns: Array, names: tuple[str, ...], notes: tuple[str, ...]) -> OutputFit:
    """Return what a search has found; IdentifyError where the parameters are not all identifiable."""
    n, missed = len(search.parameters), search.missed(unknowns)
    every = np.concatenate(missed)
    dof = every.size - len(unknowns)
    noise = np.sqrt(np.sum(every**2, axis=0) / (len(every) * dof / every.size))
    search.sigma = np.maximum(noise, search.floor)
    J = search.jacobian(unknowns)
    labels = [*search.parameters]
    for k, piece in enumerate(search.pieces):
        number = f"{k + 1} " if len(search.pieces) > 1 else ""
        labels += [f"start {number}{name}" for name in piece.unknowns]
    length = np.linalg.norm(J, axis=0)
    length[length == 0] = 1.0
    base, sizes, ways = np.linalg.svd(J / length, full_matrices=False)
    if sizes[-1] < TELLS * sizes[0]:
        part = np.abs(ways[-1])
        together = [labels[k] for k in np.argsort(-part, kind="stable") if part[k] > 0.05 * part.max()]
        raise IdentifyError(
            f"{scene.name}: {listed(names)} over time identify {listed(together)} in combination only: they can change "
            "together and leave the run as it is; look for fewer of them (the others keep their values), or "
            "measure more"
        )
    scale = np.concatenate([search.sizes, np.ones(len(unknowns) - n)])
    inverse = (ways.T / sizes) / length[:, None] * scale[:, None]
    spread = _spread(missed, base)
    spread *= dof / max(every.size - np.trace(spread), 0.1 * every.size)  # of coloured noise a fit takes more
    bases = [piece.start for piece in search.pieces]
    state = [*scene.coordinates, *scene.first_order]
    places = [state.index(one) if one in state else -1 for one in search.pieces[0].unknowns]  # a turn starts from zero
    first = np.concatenate([np.zeros(n), *([0.0 if k < 0 else float(base[k]) for k in places] for base in bases)])
    fit = OutputFit(
        scene, tuple(labels), _units(scene, search), search.before * scale + first, unknowns * scale + first,
        inverse @ spread @ inverse.T, n, names, noise, _correlations(missed), tuple(missed),
        tuple(one.t for one in search.data), float(sizes[0] / sizes[-1]), dof, search.runs,
        (*notes, *_doubts(search, missed, names, noise)),
    )  # fmt: skip
    valley = [
        f"{a} and {b} are hardly told apart (correlation of their errors {r:.4f}): intervals take the valley between "
        "them as straight, and are too narrow where it bends; the known value of one of them, or a longer or richer "
        "motion, would help"
        for a, b, r in fit.alike[:1]
    ]
    ended = ["the search ended before it had settled; begin another one at fit.scene"] * (not search.settled)
    return replace(fit, notes=(*fit.notes, *valley, *ended))


def _units(scene: Scene, search: Search) -> tuple[str, ...]:
    units = SceneUnits(scene).inferred
    states = {name: f"{unit}/s" for name, unit in zip(scene.velocities, SceneUnits(scene).velocities, strict=True)}
    states |= dict(zip(scene.coordinates, SceneUnits(scene).coordinates, strict=True))
    states |= {one.name: one.unit for one in scene.states}
    starts = (scene.shown_unit(states.get(one, "rad")) for piece in search.pieces for one in piece.unknowns)
    return (*(units[name] for name in search.parameters), *starts)


def _correlations(missed: Sequence[Array]) -> Array:
    """Return the correlation of residuals from one sample to the next, by column."""
    above = sum(np.sum(one[1:] * one[:-1], axis=0) for one in missed)
    below = sum(np.sum(one**2, axis=0) for one in missed)
    return np.asarray(above / np.where(below > 0, below, 1.0), dtype=np.float64)


MOST = 40
"""Order of an autoregressive column at most."""


def _autoregressive(columns: Sequence[Array]) -> Array:
    """Return the filter (1, a_1, ..) that leaves white noise of a residual in pieces, shape (order + 1,).

    By Burg's method, whose filters are stable; the order is that of Schwarz' criterion.
    """
    ahead, back, a = list(columns), list(columns), np.ones(1)
    count = sum(len(one) for one in columns)
    best, least, size = a, 0.0, 0.0
    for order in range(1, min(MOST, min(len(one) for one in columns) // 4) + 1):
        pairs = [(f[1:], b[:-1]) for f, b in zip(ahead, back, strict=True)]
        below = sum(float(f @ f + b @ b) for f, b in pairs)
        k = -2 * sum(float(f @ b) for f, b in pairs) / below if below > 0 else 0.0
        if not abs(k) < 1:
            break
        ahead, back = [f + k * b for f, b in pairs], [b + k * f for f, b in pairs]
        a = np.append(a, 0.0) + k * np.append(0.0, a[::-1])
        size += count * np.log1p(-k * k)
        if size + order * np.log(count) < least:
            best, least = a, size + order * np.log(count)
    return best


def _spread(missed: Sequence[Array], base: Array) -> Array:
    """Return the covariance of residuals over their scatter along directions, shape (k, k): of white noise 1.

    Args:
        missed: by piece, shape (N, m).
        base: directions: a row a sample and column, as the Jacobian has them, shape (rows, k).
    """
    from scipy.signal import lfilter

    columns = range(missed[0].shape[1])
    filters = [_autoregressive([one[:, j] for one in missed]) for j in columns]
    white = [np.column_stack([lfilter(filters[j], [1.0], one[:, j]) for j in columns]) for one in missed]
    every, whole = np.concatenate(white), np.concatenate(missed)
    size, all_of = (np.sqrt(np.maximum(np.mean(x**2, axis=0), 1e-300)) for x in (every, whole))
    together = every.T @ every / len(every) / np.outer(size, size)
    together = np.where(np.abs(together) > FAR / np.sqrt(len(every)), together, 0.0)
    np.fill_diagonal(together, 1.0)
    together *= np.outer(size / all_of, size / all_of)
    found = np.zeros((base.shape[1], base.shape[1]))
    rows = np.cumsum([one.size for one in missed])
    for part, one in zip(np.split(base[: rows[-1]], rows[:-1]), missed, strict=True):
        cube = part.reshape(*one.shape, -1)
        along = np.stack([lfilter([1.0], filters[j], cube[::-1, j], axis=0) for j in columns])
        found += np.einsum("itk,ij,jtl->kl", along, together, along, optimize=True)
    return found


def _doubts(search: Search, missed: Sequence[Array], names: Sequence[str], noise: Array) -> list[str]:
    """Return what residuals show against the result."""
    found = []
    for k, (name, r) in enumerate(zip(names, _correlations(missed), strict=True)):
        rough = np.concatenate([np.diff(one.x[:, k], 4) for one in search.data]).std() / np.sqrt(70)
        if r > WHITE and noise[k] > 10 * search.floor[k]:
            far = (
                f", and {noise[k] / rough:.2g} times the scatter of neighbouring samples"
                if noise[k] > FAR * rough
                else ""
            )
            found.append(
                f"residuals of {name} are correlated ({r:.2f} from sample to sample){far}: the scene lacks "
                "something, forces are noisy, or it is a local minimum; standard errors allow for noise alone"
            )
    return found
