"""A figure as an SVG element to stand inside a page: no header, no dates, identifiers that clash with no other."""

from __future__ import annotations

import io
import re
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def inline_svg(figure: Figure, prefix: str, label: str) -> str:
    """Return the figure as an ``<svg>`` element, the same text for the same figure.

    Parameters
    ----------
    figure : what to write.
    prefix : begins every identifier; unique on the page.
    label : what a reader hears who cannot see the figure.
    """
    from matplotlib import rc_context

    text = io.StringIO()
    with rc_context({"svg.hashsalt": prefix, "svg.fonttype": "path"}):
        figure.savefig(text, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<!--.*?-->\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\b(id="|href="#)', rf"\g<1>{prefix}-", svg)
    svg = svg.replace("url(#", f"url(#{prefix}-")
    # A hundredth of a point is less than a pixel; the digits behind it are half of the page.
    svg = re.sub(r'(?<= d=")[^"]+', _rounded, svg)
    svg = re.sub(r'(?<= [xy]=")[^"]+', _rounded, svg)
    svg = re.sub(r"(<g [^>]*)>((?:\s*<use [^>]*/>)+)", _styled_once, svg)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{escape(label)}" ', 1).strip()


def _rounded(numbers: re.Match[str]) -> str:
    return re.sub(r"(\.\d\d)\d+", r"\1", numbers[0])


def _styled_once(markers: re.Match[str]) -> str:
    """Move the style that all markers of a group share to the group."""
    styles = set(re.findall(r' style="[^"]*"', markers[2]))
    if len(styles) != 1:
        return markers[0]
    (style,) = styles
    return f"{markers[1]}{style}>{markers[2].replace(style, '')}"
