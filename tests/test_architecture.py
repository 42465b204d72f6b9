"""The rules of the house that a reader should not have to check: which way imports go, how long things get, what is
never written."""

import ast
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "robustnav"
SOURCES = sorted(PACKAGE.rglob("*.py"))
C_SOURCES = sorted(p for p in (ROOT / "csrc").rglob("*.[ch]") if p.parent.name != "generated")

LINES_IN_A_FILE = 350
LINES_IN_A_FUNCTION = 60  # without its docstring

BASE = {"errors", "units", "frames", "earth", "streams", "ranging", "records", "files", "datasheet"}
MODELS = BASE | {"model", "models", "design", "filter"}
FACTS = {"strapdown", "sim", "logs", "calibrate", "doctor", "snapshot", "survey"}  # they know little but the base row
MAY_IMPORT = {
    **dict.fromkeys(BASE, BASE),
    **dict.fromkeys(FACTS, BASE),
    "sim": BASE | {"strapdown"},
    "survey": BASE | {"snapshot"},
    "model": BASE,
    "models": BASE | {"model"},
    "design": MODELS - {"models"},
    "filter": MODELS - {"models", "design"},
    "engine": MODELS | {"snapshot", "strapdown"},
    "export": MODELS | {"engine"},
    "run": MODELS | {"engine", "snapshot", "strapdown"},
    "alignment": MODELS | {"engine", "run", "strapdown"},
    "evaluate": MODELS | {"engine", "run"} | FACTS,
    "report": MODELS | {"engine", "run", "evaluate", "export"} | FACTS,
    "studies": MODELS | {"engine", "run", "alignment", "evaluate", "export", "report"} | FACTS,
    "benchmark": MODELS | {"engine", "run", "alignment", "evaluate", "export", "report", "studies"} | FACTS,
}
ANYTHING = {"__init__", "__main__", "cli"}
# The command that writes the C of the built-in models has to know them; nothing imports it.
EXCEPTIONS = {("model/generate.py", "models")}

FORBIDDEN_CALLS = {"print", "eval", "exec", "compile", "__import__", "breakpoint"}
FORBIDDEN_MODULES = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(), str(path))


def stage(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_modules(tree: ast.Module) -> list[tuple[int, str]]:
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"relative import in line {node.lineno}"
            names = [f"{node.module}.{a.name}" for a in node.names] if node.module == "robustnav" else [node.module]
            found += [(node.lineno, str(name)) for name in names]
    return found


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_imports_go_one_way(path):
    own = stage(path)
    if own in ANYTHING:
        return
    assert own in MAY_IMPORT, (
        f"new stage {own!r}: say in this test what it may import, and in the design where it stands"
    )
    for line, module in imported_modules(tree_of(path)):
        parts = module.split(".")
        if parts[0] != "robustnav" or module == "robustnav.__version__":
            continue
        other = parts[1] if len(parts) > 1 else "robustnav"
        exempt = (str(path.relative_to(PACKAGE)), other) in EXCEPTIONS
        assert other == own or other in MAY_IMPORT[own] or exempt, f"line {line}: {own} imports {other}"


@pytest.mark.parametrize("path", [*SOURCES, *C_SOURCES], ids=name_of)
def test_files_are_short(path):
    assert len(path.read_text().splitlines()) <= LINES_IN_A_FILE


def body_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    docstring = ast.get_docstring(node, clean=False)
    return (node.end_lineno or node.lineno) - node.lineno + 1 - (len(docstring.splitlines()) if docstring else 0)


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_functions_are_short(path):
    functions = [n for n in ast.walk(tree_of(path)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    assert not [f"line {f.lineno}: {f.name}" for f in functions if body_lines(f) > LINES_IN_A_FUNCTION]


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_what_is_public_has_a_docstring(path):
    tree = tree_of(path)
    assert ast.get_docstring(tree) or not tree.body, "the module says nothing of itself"
    classes = [n for n in tree.body if isinstance(n, ast.ClassDef) and n.name[0] != "_"]
    protocols = [n for n in classes if "Protocol" in map(ast.unparse, n.bases)]  # the class says it for its members
    owners = [tree, *(n for n in classes if n not in protocols)]
    inside = [n for owner in owners for n in owner.body if isinstance(n, ast.FunctionDef | ast.ClassDef)]
    assert not [f"line {n.lineno}: {n.name}" for n in inside if n.name[0] != "_" and not ast.get_docstring(n)]


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_what_is_never_written(path):
    tree = tree_of(path)
    assert not [m for _, m in imported_modules(tree) if m.split(".")[0] in FORBIDDEN_MODULES]
    for node in ast.walk(tree):
        place = f"line {getattr(node, 'lineno', 0)}"
        if isinstance(node, ast.ExceptHandler):
            caught = ast.unparse(node.type) if node.type else "everything"
            assert caught not in ("everything", "Exception", "BaseException"), f"{place}: catches {caught}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in FORBIDDEN_CALLS, f"{place}: calls {node.func.id}"
        assert not isinstance(node, ast.Global), f"{place}: global state"


def tracked_text() -> list[Path]:
    """Files of the project that people read, as git lists them; everything below the root where there is no git."""
    try:
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError):
        pytest.skip("not a git checkout")
    endings = {".py", ".pyi", ".c", ".h", ".md", ".toml", ".sh", ".css", ".html", ""}
    return [ROOT / n for n in listed.split("\0") if n and (ROOT / n).suffix in endings and (ROOT / n).is_file()]


def test_no_file_names_a_place_on_one_machine():
    absolute = re.compile(r"(?<![\w.:/<-])/(?:home|root|tmp|work|Users|mnt|opt)/\w")
    found = []
    for path in tracked_text():
        lines = path.read_text().splitlines()
        found += [f"{name_of(path)}:{k}" for k, line in enumerate(lines, 1) if absolute.search(line)]
    assert not found


def test_every_package_is_built():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {".".join(p.parent.relative_to(PACKAGE.parent).parts) for p in SOURCES}
    assert set(setup["packages"]) - {"robustnav.engine.csrc"} == folders, "pyproject.toml: tool.setuptools.packages"


def test_every_c_source_of_the_extension_is_built():
    (extension,) = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["ext-modules"]
    folder = ROOT / "csrc" / "python"
    named = {ROOT / name for name in [*extension["sources"], *extension["depends"]]}
    assert named == set(folder.glob("*.[ch]")), "pyproject.toml: sources and depends of the extension"
