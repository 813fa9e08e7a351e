#!/bin/sh
# Runs uv with the arguments given, for the Makefile and the commit hooks.
#
# Takes the uv on PATH if it works, else installs one from PyPI into .tools/. "Works" means that it runs here:
# a version manager's shim may exist and fail, and a uv older than [tool.uv] required-version refuses.
# Names the Python to use, so that a machine without 3.12 but with a later one is as good; uv downloads none.
set -eu

cd -- "$(dirname -- "$0")/.."
UV_PYTHON_DOWNLOADS=never
UV_PROJECT_ENVIRONMENT=.venv
export UV_PYTHON_DOWNLOADS UV_PROJECT_ENVIRONMENT
unset VIRTUAL_ENV

fail() {
    echo "myostrain: $*" >&2
    exit 1
}

find_python() {
    for candidate in .venv/bin/python python3 python3.12 python3.13 python3.14 \
        "${PYENV_ROOT:-${HOME:-}/.pyenv}"/versions/3.*/bin/python3; do
        "$candidate" -c 'import sys; sys.version_info >= (3, 12) or sys.exit(1); print(sys.executable)' \
            2>/dev/null && return
    done
    return 1
}

uv_works() {
    "$1" cache dir >/dev/null 2>&1
}

install_uv() {
    echo "myostrain: no working uv on PATH, installing one into .tools/" >&2
    for python in "$UV_PYTHON" python3; do
        rm -rf .tools
        "$python" -m venv .tools >/dev/null 2>&1 &&
            .tools/bin/python -m pip install --quiet --disable-pip-version-check uv && return
        rm -rf .tools
        "$python" -m pip install --quiet --disable-pip-version-check --target .tools uv && return
    done
    fail "cannot install uv: neither 'python3 -m venv' nor 'python3 -m pip' did it" \
        "(on Debian or Ubuntu: apt install python3-venv python3-pip)"
}

# DOLFINx compiles its forms while it runs, as Python extensions: say now if that cannot work.
check_compiler() {
    "$UV_PYTHON" - <<'PYTHON'
import os
import shlex
import subprocess
import sys
import sysconfig

compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
command = [*compiler, "-fsyntax-only", "-I", sysconfig.get_path("include"), "-x", "c", "-"]
try:
    done = subprocess.run(command, input="#include <Python.h>\n", capture_output=True, text=True)
    reason = next((line for line in done.stderr.splitlines() if "error" in line), "it failed")
    works = done.returncode == 0
except OSError as error:
    reason, works = error.strerror, False
if not works:
    sys.exit(
        f"myostrain: needs a C compiler and Python's headers; tried '{compiler[0]}': {reason} "
        "(on Debian or Ubuntu: apt install gcc libc6-dev python3-dev)"
    )
PYTHON
}

UV_PYTHON=$(find_python) || fail "needs Python 3.12 or later and found none" \
    "(apt install python3 on Debian 13 or Ubuntu 24.04 and later, or: pyenv install 3.12)"
export UV_PYTHON

if [ "${1:-}" = sync ]; then
    check_compiler
fi

if uv_works uv; then
    uv=uv
else
    uv=.tools/bin/uv
    uv_works "$uv" || install_uv
fi
exec "$uv" "$@"
