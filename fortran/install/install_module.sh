#!/bin/sh
# Install the module file that programs `use`: meson knows no installation of those.
# install_module.sh FOLDER_OF_MODULES FOLDER_BELOW_THE_PREFIX
set -eu
target="$MESON_INSTALL_DESTDIR_PREFIX/$2"
mkdir -p "$target"
# The same file stays as it is, so that what depends on it is not built again.
cmp -s "$1/flankload.mod" "$target/flankload.mod" || cp "$1/flankload.mod" "$target/"
