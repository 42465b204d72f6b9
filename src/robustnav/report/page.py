"""One self-contained HTML page: text, key figures, tables, figures, warnings and how to repeat it.

No script, no font, no picture from elsewhere; equal content gives equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from pathlib import Path
from typing import Literal

from robustnav.evaluate.tables import Row, cells, columns_of, heading, numeric_columns, plain
from robustnav.files import write_whole
from robustnav.report.drawing import Plot
from robustnav.report.svg import inline_svg

Level = Literal["ok", "info", "warning", "error"]
LEVEL_WORDS: dict[Level, str] = {"ok": "Passed", "info": "Note", "warning": "Warning", "error": "Failed"}
VERDICT_WORDS = LEVEL_WORDS | {"info": "Result"}

# The policy makes a browser refuse what should not be there in the first place.
_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>{title}</title>
<style>
{css}</style>
</head>
<body>
<main>
<header>
<p class="mark">robustnav</p>
<h1>{title}</h1>
<p class="subtitle">{subtitle}</p>
</header>
"""
_FOOT = "</main>\n</body>\n</html>\n"


@dataclass(frozen=True)
class Tile:
    """A key figure: what it is, its value as text, its unit, and a short remark."""

    name: str
    value: str
    unit: str = ""
    remark: str = ""


class Page:
    """A page that collects its parts in reading order.

    Parameters
    ----------
    title, subtitle : of the whole page, plain text.
    """

    def __init__(self, title: str, subtitle: str = "") -> None:
        self._title, self._subtitle = title, subtitle
        self._parts: list[str] = []
        self._figures = 0

    def section(self, title: str) -> None:
        """Begin a section."""
        self._parts.append(f"<h2>{escape(title)}</h2>")

    def text(self, text: str) -> None:
        """Add a paragraph."""
        self._parts.append(f"<p>{escape(text)}</p>")

    def verdict(self, level: Level, text: str, reasons: Iterable[str] = ()) -> None:
        """Add the verdict: one sentence, and the reasons as a list; ``info`` is a result that nothing has tested."""
        items = "".join(f"<li>{escape(reason)}</li>" for reason in reasons)
        self._parts.append(
            f'<div class="verdict {level}"><p><strong>{VERDICT_WORDS[level]}:</strong> {escape(text)}</p>'
            + (f"<ul>{items}</ul>" if items else "")
            + "</div>"
        )

    def tiles(self, tiles: Sequence[Tile]) -> None:
        """Add key figures side by side."""
        boxes = "\n".join(
            f'<div class="tile"><dt>{escape(tile.name)}</dt>'
            f'<dd><span class="value">{escape(tile.value)}</span> <span class="unit">{escape(tile.unit)}</span></dd>'
            f'<dd class="remark">{escape(tile.remark)}</dd></div>'
            for tile in tiles
        )
        self._parts.append(f'<dl class="tiles">\n{boxes}\n</dl>')

    def table(self, rows: Sequence[Row], caption: str) -> None:
        """Add rows as a table, numbers to the right; nothing without rows."""
        if not rows:
            return
        names, numeric = columns_of(rows), numeric_columns(rows)
        kinds = [' class="number"' if name in numeric else "" for name in names]
        head = "".join(f'<th scope="col"{k}>{escape(heading(name))}</th>' for k, name in zip(kinds, names, strict=True))
        body = "\n".join(
            "<tr>" + "".join(f"<td{k}>{escape(cell)}</td>" for k, cell in zip(kinds, line, strict=True)) + "</tr>"
            for line in cells(rows)
        )
        self._parts.append(
            f'<div class="wide" tabindex="0"><table>\n<caption>{escape(caption)}</caption>\n'
            f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>"
        )

    def figure(self, plot: Plot) -> None:
        """Add a figure with its caption and number."""
        self._figures += 1
        svg = inline_svg(plot.figure, f"f{self._figures}", plot.caption)
        self._parts.append(
            f'<figure>\n<div class="wide" tabindex="0">{svg}</div>\n'
            f"<figcaption><strong>Figure {self._figures}.</strong> {escape(plot.caption)}</figcaption>\n</figure>"
        )

    def notes(self, notes: Iterable[str], level: Level = "info") -> None:
        """Add notes or warnings, one line each; nothing without any."""
        items = "\n".join(
            f'<li class="{level}"><strong>{LEVEL_WORDS[level]}:</strong> {escape(note)}</li>' for note in notes
        )
        if items:
            self._parts.append(f'<ul class="notes">\n{items}\n</ul>')

    def settings(self, settings: Mapping[str, object], versions: Mapping[str, str], command: str = "") -> None:
        """Add what is needed to repeat the result: settings, versions of the software, the command.

        Raises
        ------
        InputError : a setting with no plain form.
        """
        for title, values in (("Settings", settings), ("Versions", versions)):
            lines = "\n".join(
                f"<div><dt>{escape(name)}</dt><dd>{escape(_setting(value))}</dd></div>"
                for name, value in values.items()
            )
            if lines:
                self._parts.append(f'<h3>{title}</h3>\n<dl class="settings">\n{lines}\n</dl>')
        if command:
            self._parts.append(f"<h3>Command to repeat</h3>\n<pre><code>{escape(command)}</code></pre>")

    def html(self) -> str:
        """Return the page."""
        css = resources.files("robustnav.report").joinpath("page.css").read_text(encoding="utf-8")
        head = _HEAD.format(title=escape(self._title), subtitle=escape(self._subtitle), css=css)
        return head + "\n".join(self._parts) + "\n" + _FOOT

    def write(self, path: str | Path) -> Path:
        """Write the page whole or not at all, and return its path.

        Raises
        ------
        InputError : the path is a folder.
        """
        return write_whole(path, self.html())


def _setting(value: object) -> str:
    value = plain(value)
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
