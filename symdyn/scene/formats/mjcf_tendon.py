"""Tendons whose length is a sum of joint positions (fixed tendons), and what an equality of tendons says of the joints.

    length = Σ c_j q_j                             of a fixed tendon
    (L1 - L1 ref) - a0 - a1 (L2 - L2 ref) = 0      an equality, L2 left out: a1 = 0; ref: as the file draws it

so an equality of degree one is Σ k_j (q_j - q_j ref) = a0, a coupling where exactly two k_j are not zero. Reference:
MuJoCo documentation, "XML Reference", tendon/fixed and equality/tendon.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symdyn.scene.values.names import listed

ADVICE = "delete it, convert to TOML, and say there what it does: a row [rows.NAME] with a formula in velocities"


class NoCouplingError(Exception):
    """Why an equality of tendons couples no two joints."""


def tied(mujoco: Any, model: Any, i: int, names: Sequence[str]) -> dict[int, float]:
    """Return k_j of the joints that equality i ties, two of them.

    Args:
        mujoco: the package.
        model: compiled.
        i: number of an equality of tendons.
        names: of the joints.

    Raises:
        NoCouplingError: why it is no coupling of two joints.
    """
    first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
    _, slope, *higher = (float(x) for x in model.eq_data[i][:5])
    if second >= 0 and any(higher):
        raise NoCouplingError(
            f"ties two tendons by a polynomial of higher degree, which is no linear coupling; {ADVICE}"
        )
    found = _coefficients(mujoco, model, first)
    for joint, x in _coefficients(mujoco, model, second).items() if second >= 0 else ():
        found[joint] = found.get(joint, 0.0) - slope * x
    found = {joint: x for joint, x in found.items() if x}
    if len(found) == 2:
        return found
    tells = f"ties {len(found)} joints ({listed(names[j] for j in found)}), and a coupling ties two"
    if len(found) == 1:
        raise NoCouplingError(
            f"{tells}; it holds this joint still: delete the joint, or lock it in TOML (locked = true)"
        )
    raise NoCouplingError(f"{tells}; {ADVICE}")


def _coefficients(mujoco: Any, model: Any, tendon: int) -> dict[int, float]:
    """Return how a fixed tendon's length depends on joints."""
    start = int(model.tendon_adr[tendon])
    found: dict[int, float] = {}
    for wrap in range(start, start + int(model.tendon_num[tendon])):
        if model.wrap_type[wrap] != mujoco.mjtWrap.mjWRAP_JOINT:
            name = model.tendon(tendon).name or tendon + 1
            raise NoCouplingError(
                f"the tendon {name} runs through space, and its length is no sum of joint positions; delete it, or "
                'make it a loop with a joint of type "rod" in TOML'
            )
        joint = int(model.wrap_objid[wrap])
        found[joint] = found.get(joint, 0.0) + float(model.wrap_prm[wrap])
    return found
