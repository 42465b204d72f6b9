"""How errors move a state, as expressions: x [+] e and a [-] b, block by block (docs/models.md, section 1)."""

from __future__ import annotations

from robustnav.model.blocks import Model, Rotation
from robustnav.model.derive import Derivation, Exprs, matrix, product, quat_product, transpose
from robustnav.model.program import Program


def moved(derivation: Derivation, program: Program, x: Exprs, error: Exprs, *, turned: bool = False) -> Exprs:
    """Return x [+] e; ``turned``: body vectors of e are given in navigation axes."""
    model, out = derivation.model, []
    rotation = model.rotation
    turned = turned and rotation is not None and rotation.error == "n"
    for block in model.state:
        part, e = x[model.state_slices[block.name]], error[model.error_slices[block.name]]
        if isinstance(block, Rotation):
            out += _turned_quaternion(program, part, e, block.error)
        elif turned and block.frame == "b":
            C_bn = transpose(matrix(derivation.quaternion(x)))
            out += [a + r[0] for a, r in zip(part, product(C_bn, [[v] for v in e]), strict=True)]
        else:
            out += [a + v for a, v in zip(part, e, strict=True)]
    return out


def difference(derivation: Derivation, program: Program, a: Exprs, b: Exprs) -> Exprs:
    """Return a [-] b, the error e of a = b [+] e."""
    out: Exprs = []
    for block in derivation.model.state:
        part = derivation.model.state_slices[block.name]
        one, other = a[part], b[part]
        if isinstance(block, Rotation):
            inverse = [other[0], *(-v for v in other[1:])]
            d = quat_product(one, inverse) if block.error == "n" else quat_product(inverse, one)
            w = program.let("half_w", d[0] / 2)
            out += [v / w for v in d[1:]]
        else:
            out += [p - m for p, m in zip(one, other, strict=True)]
    return out


def _turned_quaternion(program: Program, q: Exprs, e: Exprs, error: str) -> Exprs:
    import symengine as se

    turn = [se.Integer(1), *(v / 2 for v in e)]
    out = program.let_all("turned", quat_product(turn, q) if error == "n" else quat_product(q, turn))
    scale = program.let("scale", 1 / se.sqrt(sum(v * v for v in out)))
    return [v * scale for v in out]


def transport(model: Model) -> list[str]:
    """Return the C that turns a covariance with a correction ``dx`` of attitude, where the model asks for it."""
    rotation = model.rotation
    if rotation is None or not rotation.transported:
        return []
    at, sign = model.error_slices[rotation.name].start, "" if rotation.error == "n" else "-"
    turn = ", ".join(f"{sign}dx[{at + i}]" for i in range(3))
    return [f"rn_transport(P, {model.error_size}, {at}, {turn});"]
