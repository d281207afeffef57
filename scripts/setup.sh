#!/bin/sh
# Sets up a virtual environment in the checkout; make calls it and remembers that it did.
#
#   scripts/setup.sh FOLDER venv    the empty environment
#   scripts/setup.sh FOLDER core    kendon and what it cannot do without
#   scripts/setup.sh FOLDER all     every extra too, the system libraries they need, and ROS 1
#                                   for its tests, where the system has it
#
# On a Debian kin and as root it installs what the system lacks; otherwise it says what to run.
set -eu
cd "$(dirname "$0")/.."
venv=$1
stage=$2

# The Pythons for which every pinned package has a ready-made wheel; newer ones are a second choice.
newest_tried=13

# The shared libraries that the wheels of the extras load but do not bring, and the Debian package
# of each. OpenCV's windows need the first three, MediaPipe's graphics the last two.
system_libraries='
    libxcb.so.1:libxcb1
    libGL.so.1:libgl1
    libgthread-2.0.so.0:libglib2.0-0
    libEGL.so.1:libegl1
    libGLESv2.so.2:libgles2
'

say() {
    printf '%s\n' "$*"
}

die() {
    printf 'kendon cannot be set up: %s\n' "$*" >&2
    exit 1
}

# Runs a command in silence, and shows what it printed if it fails.
quietly() {
    log=$(mktemp)
    if "$@" </dev/null >"$log" 2>&1; then
        rm -f "$log"
    else
        cat "$log" >&2
        rm -f "$log"
        die "'$*' failed; what it said is above."
    fi
}

# apt_install REASON PACKAGE...
apt_install() {
    reason=$1
    shift
    if ! command -v apt-get >/dev/null; then
        die "$reason; install them with the system's package manager (Debian's names: $*)."
    fi
    if [ "$(id -u)" != 0 ]; then
        die "$reason; run this, then try again:  sudo apt-get update && sudo apt-get install -y $*"
    fi
    say "Installing Debian's $* (10 to 30 seconds)."
    export DEBIAN_FRONTEND=noninteractive
    quietly apt-get update
    quietly apt-get install -y --no-install-recommends "$@"
}

# find_python NEWEST_MINOR: prints the first Python 3.11 to 3.NEWEST_MINOR there is.
find_python() {
    for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11 python3.14}; do
        if "$candidate" -c "import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, $1))" \
            2>/dev/null; then
            printf '%s\n' "$candidate"
            return
        fi
    done
}

make_venv() {
    python=$(find_python "$newest_tried")
    [ -n "$python" ] || python=$(find_python 99)
    if [ -z "$python" ]; then
        wanted=${PYTHON:-python3}
        if found=$("$wanted" --version 2>/dev/null); then
            die "it needs Python 3.11 or newer, and $wanted is $found; name another: make PYTHON=python3.12"
        fi
        die "it needs Python 3.11 or newer, and there is no $wanted here (on Debian 12: apt-get install python3)."
    fi
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        # Debian splits these two off from its Python.
        version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
        apt_install "$python lacks the modules venv and ensurepip" "python$version-venv"
    fi
    say "Making $venv with $("$python" --version) (5 seconds)."
    # --clear: what is there may be half made, or belong to a Python that is gone.
    quietly "$python" -m venv --clear "$venv"
}

# Prints the Debian packages of those system libraries that cannot be loaded.
missing_packages() {
    [ "$(uname -s)" = Linux ] || return 0
    # shellcheck disable=SC2086  # one argument a library is meant
    "$venv/bin/python" - $system_libraries <<'PYTHON'
import ctypes
import sys

for library in sys.argv[1:]:
    name, package = library.split(":")
    try:
        ctypes.CDLL(name)
    except OSError:
        print(package)
PYTHON
}

# Prints the Debian packages of ROS 1 if it is not here.
missing_ros1() {
    "$venv/bin/python" - <<'PYTHON'
from kendon.ros.ros1.environment import PACKAGES, RosMissingError, require_ros1

try:
    require_ros1()
except RosMissingError:
    print(*PACKAGES)
PYTHON
}

# ROS 1 is for robots that have it: what is here is tested, and what is not here is no mistake.
try_ros1() {
    packages=$(missing_ros1)
    [ -n "$packages" ] || return 0
    command -v apt-get >/dev/null && [ "$(id -u)" = 0 ] || return 0
    export DEBIAN_FRONTEND=noninteractive
    quick="-o Acquire::Retries=0 -o Acquire::http::Timeout=10"
    # Without lists of packages, which fresh containers lack, nothing is known of these.
    apt-cache show python3-rospy >/dev/null 2>&1 || apt-get $quick update >/dev/null 2>&1 || true
    # Debian 12 and Ubuntu 22.04 have it, newer ones do not.
    apt-cache show python3-rospy >/dev/null 2>&1 || return 0
    say "Installing Debian's ROS 1 for its tests (7 MB; 10 seconds)."
    # shellcheck disable=SC2086  # one argument a package is meant
    apt-get $quick install -y --no-install-recommends $packages >/dev/null 2>&1 </dev/null ||
        say "It could not be installed: the tests of ROS 1 are skipped."
}

# --no-compile: Python compiles what it imports when it imports it, so compiling every file of
# every package beforehand would nearly double the wait.
pip_install() {
    quietly "$venv/bin/python" -m pip install --disable-pip-version-check --no-compile "$@"
}

case $stage in
venv)
    make_venv
    ;;
core)
    # An interrupted set-up leaves a Python without pip.
    "$venv/bin/python" -m pip --version >/dev/null 2>&1 || make_venv
    say "Installing kendon into $venv (half a minute; longer on a slow connection)."
    pip_install --constraint constraints.txt --editable .
    ;;
all)
    # Read from pyproject.toml, so that a new extra needs no change here.
    extras=$("$venv/bin/python" -c '
import tomllib
with open("pyproject.toml", "rb") as file:
    print(",".join(tomllib.load(file)["project"]["optional-dependencies"]))')
    packages=$(missing_packages)
    # shellcheck disable=SC2086  # one argument a package is meant
    [ -z "$packages" ] || apt_install "the camera needs system libraries that are missing" $packages
    say "Installing the extras $extras (300 MB; about a minute)."
    pip_install --constraint constraints.txt --editable ".[$extras]"
    try_ros1
    ;;
*)
    die "there is no stage '$stage'; valid: venv, core, all."
    ;;
esac
