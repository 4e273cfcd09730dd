#!/bin/sh
# Build the Debian packages of the last commit in FOLDER and check them with lintian.
# build.sh FOLDER
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
version=$(sed -n "s/^ *version: '\(.*\)',$/\1/p" "$root/meson.build" | head -1)
source=$1/flankload-$version
rm -rf "$source"
mkdir -p "$1"
git -C "$root" archive --prefix="flankload-$version/" -o "$1/flankload_$version.orig.tar.gz" HEAD
tar -xf "$1/flankload_$version.orig.tar.gz" -C "$1"
cp -r "$root/packaging/debian" "$source/debian"
rm "$source/debian/build.sh" "$source/debian/changelog.in"
date=$(git -C "$root" log -1 --format=%cD)
sed "s/@VERSION@/$version/; s/@DATE@/$date/" "$root/packaging/debian/changelog.in" >"$source/debian/changelog"
cd "$source"
# -d: meson may come from elsewhere where that of the distribution is too old (Debian 12)
dpkg-buildpackage -us -uc -d
lintian --fail-on error --info "../flankload_${version}-1_$(dpkg --print-architecture).changes"
