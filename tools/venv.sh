#!/bin/sh
# Make or mend .venv and install the project into it with one extra: tools/venv.sh report|dev.  Called by make.
# PYTHON, when set, names the interpreter .venv must be made from; CC the C compiler.
set -eu
cd "$(dirname "$0")/.."
extra=$1
wanted=${PYTHON:-python3}
python=.venv/bin/python

fail() {
  printf 'robustnav: %s\n' "$@" >&2
  exit 1
}

recent='import sys; sys.exit(sys.version_info < (3, 11))'
base='import sys; print(sys.base_prefix, sys.version)'
if ! "$python" -c "import pip; $recent" 2>/dev/null ||
  { [ -n "${PYTHON:-}" ] && [ "$("$python" -c "$base")" != "$("$PYTHON" -c "$base" 2>/dev/null)" ]; }; then
  "$wanted" -c "$recent" 2>/dev/null || fail \
    "Python 3.11 or later is needed; '$wanted' is $("$wanted" --version 2>&1 || true)" \
    "name another: make PYTHON=python3.12"
  echo "making .venv with $("$wanted" --version)"
  "$wanted" -m venv --clear .venv || fail \
    "'$wanted' cannot make a virtual environment; on Debian: apt-get install python3-venv"
fi

compiler=${CC:-$("$python" -c 'import sysconfig; print(sysconfig.get_config_var("CC"))')}
command -v "${compiler%% *}" >/dev/null || fail \
  "a C compiler is needed; '${compiler%% *}' is not installed" "on Debian: apt-get install gcc libc6-dev; or set CC"
header=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h
[ -e "$header" ] || fail "Python's C header is missing: $header" "on Debian: apt-get install python3-dev"

echo "installing robustnav[$extra] into .venv"
"$python" -m pip install -qq --disable-pip-version-check --no-input --root-user-action=ignore --editable ".[$extra]"
