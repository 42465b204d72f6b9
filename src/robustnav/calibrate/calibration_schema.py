"""What a calibration file may hold; the form is described in ``calibrate.calibration_file``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from robustnav.calibrate.bias_curve import BiasCurve
from robustnav.calibrate.range_line import Fitted, RangeLine
from robustnav.calibrate.ranges import RangeCalibration
from robustnav.calibrate.robust import Loss
from robustnav.errors import InputError

Number = Annotated[float, Field(allow_inf_nan=False)]
Variance = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=0, lt=2**63)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class FittedTable(_Table):
    """``[correction.fitted]``."""

    covariance: list[list[Number]]
    dof: Count
    variance_dof: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    samples: Count
    files: Count
    outliers: Count
    distance_min_m: Number
    distance_max_m: Number
    loss: str
    loss_constant: float

    def record(self, size: int) -> Fitted:
        """Return the record of a correction with ``size`` coefficients; raise ``InputError`` for another covariance."""
        if len(self.covariance) != size or any(len(row) != size for row in self.covariance):
            raise InputError(
                "covariance", got=f"{len(self.covariance)} rows", expected=f"{size} rows of {size} numbers"
            )
        return Fitted(
            tuple(tuple(row) for row in self.covariance),
            self.dof,
            self.variance_dof,
            self.samples,
            self.files,
            self.outliers,
            self.distance_min_m,
            self.distance_max_m,
            Loss(self.loss, self.loss_constant),
        )


class LineTable(_Table):
    """``[[correction]]`` of a line."""

    key: list[str]
    slope: Number
    offset_m: Number
    range_variance_m2: Variance
    fitted: FittedTable | None = None

    def record(self) -> RangeLine:
        """Return the line."""
        fitted = self.fitted.record(2) if self.fitted else None
        return RangeLine(self.slope, self.offset_m, self.range_variance_m2, fitted)


class CurveTable(_Table):
    """``[[correction]]`` of a curve."""

    key: list[str]
    knots_m: list[Number]
    bias_m: list[Number]
    range_variance_m2: Variance
    fitted: FittedTable | None = None

    def record(self) -> BiasCurve:
        """Return the curve."""
        fitted = self.fitted.record(len(self.knots_m)) if self.fitted else None
        return BiasCurve(tuple(self.knots_m), tuple(self.bias_m), self.range_variance_m2, fitted)


class CalibrationTable(_Table):
    """A whole file."""

    calibration: Literal["ranges"]
    by: str
    source: str = ""
    correction: Annotated[list[LineTable | CurveTable], Field(min_length=1)]

    def record(self) -> RangeCalibration:
        """Return the calibration; raise ``InputError`` for what its records refuse, and for a key that stands twice."""
        keys = [tuple(one.key) for one in self.correction]
        twice = [key for key in keys if keys.count(key) > 1]
        if twice:
            raise InputError("keys", got=f"{twice[0]} twice", expected="one correction for each")
        records = [one.record() for one in self.correction]
        return RangeCalibration(self.by, dict(zip(keys, records, strict=True)), self.source)
