"""Where anchors stand, from ranges between them and to a moving tag, with a verdict on whether to believe it."""

from robustnav.survey.anchors_file import write_anchors
from robustnav.survey.record import (
    AnchorSurvey,
    Frame,
    Known,
    Layout,
    Links,
    Measured,
    Options,
    Suspect,
    TagRanges,
    Weak,
)
from robustnav.survey.solve import survey_anchors

__all__ = [
    "AnchorSurvey",
    "Frame",
    "Known",
    "Layout",
    "Links",
    "Measured",
    "Options",
    "Suspect",
    "TagRanges",
    "Weak",
    "survey_anchors",
    "write_anchors",
]
