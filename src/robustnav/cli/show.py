"""What the terminal sees: results on standard output, everything else on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from robustnav.errors import RobustnavError
from robustnav.evaluate.tables import Row, plain, text_table


def say(text: str = "") -> None:
    """Write a result line."""
    sys.stdout.write(text + "\n")


def note(text: str) -> None:
    """Write what is not a result: hints and warnings."""
    sys.stderr.write(text + "\n")


def say_json(document: object) -> None:
    """Write one JSON document and nothing else; NaN becomes null."""
    say(json.dumps(plain(document), indent=2, ensure_ascii=False, allow_nan=False))


def say_table(title: str, rows: Sequence[Row]) -> None:
    """Write a titled table."""
    say(f"\n{title}")
    say(text_table(rows))


def say_settings(settings: Mapping[str, object]) -> None:
    """Write settings, one a line."""
    width = max((len(name) for name in settings), default=0)
    for name, value in settings.items():
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        say(f"  {name:<{width}}  {text}")


def complain(error: RobustnavError) -> int:
    """Write an error as users can act on it, and return its exit code."""
    note(f"error: {error}")
    return error.exit_code


@contextmanager
def progress(title: str, total: int, *, quiet: bool) -> Iterator[Callable[[], None]]:
    """Show a bar on standard error while work lasts, if that is a terminal; yields what to call after each part."""
    if quiet or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, refresh_per_second=10) as bar:
        task = bar.add_task(title, total=total)
        yield lambda: bar.advance(task)
