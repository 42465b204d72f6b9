"""Write the committed C of the built-in models: ``python -m robustnav.model.generate [--check]``."""

from __future__ import annotations

import sys
from pathlib import Path

from robustnav.model.blocks import Model
from robustnav.model.codegen import model_header


def built_in_models() -> list[Model]:
    """Return the models whose C ships with the package; their numbers do not matter here."""
    from robustnav.models import (
        AidingNoise,
        AlignmentNoise,
        AttitudeNoise,
        InertialNoise,
        RangeBias,
        alignment,
        alignment_so3,
        attitude,
        attitude_euler,
        inertial,
        uwb,
    )
    from robustnav.models.uwb_planar import uwb_planar

    noise, unit = AttitudeNoise(1.0, 1.0, 1.0, 1.0), AlignmentNoise(1.0, 1.0, 1.0, 1.0, 1.0)
    tags = [
        uwb(range_sd=1.0, acceleration_density=1.0, dimensions=n, driven=driven, bias=bias)
        for n in (2, 3)
        for driven, bias in ((False, None), (True, None), (False, RangeBias(1.0, 1.0, 1.0)))
    ]
    return [
        attitude(noise, field=1.0, dip_deg=60.0),
        attitude_euler(noise, field=1.0, dip_deg=60.0),
        *tags,
        inertial(InertialNoise(1.0, 1.0, 1.0, 1.0), AidingNoise()),
        inertial(InertialNoise(1.0, 1.0, 1.0, 1.0), AidingNoise(), bias=RangeBias(1.0, 1.0, 1.0)),
        uwb_planar(range_sd=1.0, acceleration_density=1.0, yaw_acceleration_density=1.0),
        alignment(unit, gravity=1.0, earth_rate_north=1.0, earth_rate_down=1.0),
        *(
            alignment_so3(unit, gravity=1.0, earth_rate_north=1.0, earth_rate_down=1.0, lines=lines)
            for lines in ((), (1.0, 1.0, 1.0))
        ),
    ]


def generated_files() -> dict[str, str]:
    """Return the text of every generated file by name."""
    models = built_in_models()
    files = {f"rn_{m.name}.h": model_header(m) for m in models}
    includes = "".join(f'#include "rn_{m.name}.h"\n' for m in models)
    table = "".join(f"    &rn_{m.name}_model,\n" for m in models)
    files["rn_models.h"] = (
        "/* Generated: the list of built-in models; do not edit: make generate. */\n"
        f"#ifndef RN_MODELS_H\n#define RN_MODELS_H\n{includes}\n"
        f"static const RN(model) *const rn_built_in[] = {{\n{table}    0}};\n\n#endif\n"
    )
    return files


def main(arguments: list[str]) -> int:
    """Write the generated files below ``csrc/generated``, or with ``--check`` compare and name what differs."""
    folder = Path(__file__).parents[3] / "csrc" / "generated"
    different = []
    for name, text in generated_files().items():
        path = folder / name
        if not path.exists() or path.read_text() != text:
            different.append(name)
            if "--check" not in arguments:
                path.write_text(text)
    state = "differ from the models" if "--check" in arguments else "written"
    sys.stdout.write(f"generated C: {', '.join(different) + ' ' + state if different else 'up to date'}\n")
    return 1 if different and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
