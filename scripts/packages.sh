# Sourced by ./demo, ./check and the scripts that build: installs missing Debian packages.

packages_to_build=(
  cmake dpkg-dev file flatbuffers-compiler g++ help2man libassimp-dev libbearssl-dev libboost-dev libcli11-dev libeigen3-dev libflatbuffers-dev libfmt-dev
  libgpiod-dev libmnl-dev libmosquitto-dev libpng-dev libqhull-dev liburdfdom-dev ninja-build nlohmann-json3-dev pkgconf pybind11-dev
  python3-dev python3-numpy zlib1g-dev
)
# Packages for the viewer's page. Packages from Node.js itself include npm and conflict with Debian's npm.
command -v npm >/dev/null || packages_to_build+=(nodejs npm)
# For the tests, where they are built (THIMBLE_TESTS); `thimble plot` needs gnuplot too.
packages_to_test=(
  assimp-testmodels gnuplot-nox libbenchmark-dev libbox2d-dev libbullet-dev libembree-dev libgl-dev libgmock-dev libgtest-dev libmujoco-dev
  libode-dev liborocos-kdl-dev librapidcheck-dev mricron-data
)
# For ./check: what its tests run.
packages_to_check=(
  binutils chromium-headless-shell clang clang-format clang-tidy cpio device-tree-compiler fish g++-aarch64-linux-gnu g++-arm-linux-gnueabihf gcc-12
  gcc-arm-none-eabi git hdf5-tools libclang-rt-dev libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib llvm make man-db mosquitto mosquitto-clients mypy python3-can python3-canmatrix python3-h5py python3-markdown-it python3-matplotlib python3-paho-mqtt python3-pandas python3-pip qemu-system-arm qemu-system-x86 qemu-user strace
  systemd tshark valgrind verilator xz-utils yosys z3 zsh
)

# For ./check --long.
packages_to_check_long=(chromium clang-22 firefox-esr googletest libc++-22-dev libc++abi-22-dev mmdebstrap munge slurm-wlm)

# For the manual, target `manual` (cmake/manual.cmake).
packages_to_document=(doxygen furo python3-breathe python3-myst-parser python3-sphinx python3-sphinx-copybutton)

# For the static site, ./demo --page: modules for a browser (cmake/toolchains/wasm32-wasi.cmake).
packages_to_page=(clang-22 lld-22 libc++-22-dev-wasm32 libc++abi-22-dev-wasm32 libclang-rt-22-dev-wasm32 libutfcpp-dev llvm-22 wasi-libc)

install_packages() {
  local missing=()
  for package in "$@"; do
    dpkg-query --show --showformat='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then return 0; fi
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "Missing packages: ${missing[*]}. Run as root, or install sudo." >&2; return 1; }
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}" >&2
  "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=400 -qq update >&2
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=400 -qq install --no-install-recommends --yes "${missing[@]}" >&2
}
