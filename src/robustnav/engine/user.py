"""Compile a user's own model with the system's C compiler, once; afterwards it loads from a cache.

The library is built in a folder only the user can read, under a name that hashes its source, the kernel, the compiler
and the flags; it is written beside and renamed, and one that belongs to somebody else is never loaded.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import stat
import subprocess
import sys
import tempfile
from importlib import resources
from pathlib import Path

from robustnav.engine import _kernel
from robustnav.engine.compiled import CompiledModel
from robustnav.errors import InputError, RobustnavError
from robustnav.model.blocks import Model

_FLAGS = [
    "-std=c99",
    "-O3",
    "-fno-tree-vectorize",
    "-DRN_UNROLL",
    "-fno-math-errno",
    "-shared",
    "-fPIC",
    "-fvisibility=hidden",
]
_SYMBOL = "rn_user_model"


class NoCompiler(RobustnavError):
    """No C compiler was found; NumPy runs the model instead, slower, with the same result."""


def find_compiler() -> list[str]:
    """Return the command of a C compiler: ``$CC``, ``cc``, ``gcc``, ``clang``, or the ziglang package.

    Raises
    ------
    NoCompiler : none is installed.
    InputError : ``$CC`` names a command that does not exist.
    """
    wanted = os.environ.get("CC", "").split()
    if wanted and not shutil.which(wanted[0]):
        raise InputError("C compiler", place="environment variable CC", got=wanted[0], expected="an installed command")
    for name in [wanted[0]] if wanted else ["cc", "gcc", "clang"]:
        path = shutil.which(name)
        if path:
            return [path, *wanted[1:]]
    try:
        import ziglang  # type: ignore[import-not-found, unused-ignore]
    except ModuleNotFoundError:
        raise NoCompiler(
            "no C compiler found",
            expected="cc, gcc or clang on the PATH, or CC set",
            do='install one, or pip install ziglang, or run with backend="numpy"',
        ) from None
    return [sys.executable, "-m", ziglang.__name__, "cc"]


def compile_model(model: Model) -> CompiledModel:
    """Return a model's compiled functions: built in, from the cache, or compiled now (under a second).

    Raises
    ------
    NoCompiler : no C compiler is installed.
    MissingExtra : SymPy or symengine is not installed.
    InputError : the model's equations have no C form, or the compiler refuses them.
    """
    if model.prebuilt:
        return CompiledModel(model)
    library = _library(model)
    handle = ctypes.CDLL(str(library))
    address = ctypes.addressof(ctypes.c_char.in_dll(handle, _SYMBOL))
    try:
        compiled = _kernel.Model(model.name, "double", address, handle)
    except ValueError as why:
        raise InputError(f"model {model.name!r}", got=str(why), do='run with backend="numpy"') from why
    return CompiledModel(model, compiled)


def _library(model: Model) -> Path:
    from robustnav.model.codegen import model_header

    compiler, kernel = find_compiler(), kernel_folder()
    header = model_header(model)
    version = _call([*compiler, "--version"]).stdout
    parts = [header, *(p.read_text() for p in sorted(kernel.glob("rn_*.h"))), *compiler, version, *_FLAGS, sys.platform]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]
    folder = _cache_folder()
    library = folder / f"{model.name}-{key}.so"
    if library.exists():
        _check_owner(library)
        return library
    with tempfile.TemporaryDirectory(dir=folder) as work:
        source = Path(work) / f"rn_{model.name}.h"
        source.write_text(header)
        unit = Path(work) / "model.c"
        unit.write_text(
            f'#include "rn_{model.name}.h"\n'
            f'extern __attribute__((visibility("default"))) const RN(model) {_SYMBOL};\n'
            f"const RN(model) {_SYMBOL} = {{{_copied_table(header)}}};\n"
        )
        built = Path(work) / "model.so"
        command = [*compiler, *_FLAGS, f"-I{kernel}", f"-I{work}", "-o", str(built), str(unit), "-lm"]
        result = _call(command)
        if result.returncode:
            raise InputError(
                f"the compiler refused model {model.name!r}",
                place=" ".join(compiler),
                got=result.stderr.strip()[:500] or f"exit code {result.returncode}",
                do='run with backend="numpy", and please report the model',
            )
        built.chmod(0o700)  # whatever the umask: a library that others can write is not loaded
        os.replace(built, library)
    return library


def _copied_table(header: str) -> str:
    """The initialiser of the generated model table: C99 has no copy of a static struct in an initialiser."""
    start = header.rindex("_model = {") + len("_model = {")
    return header[start : header.index("};", start)]


def kernel_folder() -> Path:
    """The kernel's headers: in the installed package, or in the checkout beside it."""
    packaged = Path(str(resources.files("robustnav.engine"))) / "csrc"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "csrc"


def _cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    folder = Path(base) / "robustnav" / "models"
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    folder.chmod(0o700)
    _check_owner(folder)
    return folder


def _check_owner(path: Path) -> None:
    status = path.stat()
    if hasattr(os, "getuid") and (status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        raise InputError(
            "compiled model",
            place=str(path),
            got="a file that other users own or can write",
            expected="one that only you can write",
            do="remove it and run again",
        )


def _call(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as why:
        raise InputError("C compiler", place=command[0], got=str(why), expected="a command that runs") from why
