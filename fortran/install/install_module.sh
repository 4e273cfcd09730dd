#!/bin/sh
# Install the module file for `use flankload`: meson does not install module files.
# install_module.sh FOLDER_OF_MODULES FOLDER_BELOW_THE_PREFIX
set -eu
target="$MESON_INSTALL_DESTDIR_PREFIX/$2"
mkdir -p "$target"
# An identical file is not replaced, so that programs that depend on it are not rebuilt.
cmp -s "$1/flankload.mod" "$target/flankload.mod" || cp "$1/flankload.mod" "$target/"
