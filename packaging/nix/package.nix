# For nixpkgs: python3Packages.callPackage ./package.nix { }
{
  lib,
  buildPythonPackage,
  pythonOlder,
  gfortran,
  pkg-config,
  openblas,
  meson,
  meson-python,
  ninja,
  numpy,
  scipy,
  meshio,
  msgspec,
  matplotlib,
  jinja2,
  rich,
  threadpoolctl,
}:

buildPythonPackage {
  pname = "flankload";
  version = "0.1.0";
  pyproject = true;

  disabled = pythonOlder "3.11";

  # a checkout: the project has no public address yet
  src = lib.cleanSource ../..;

  build-system = [
    meson # >= 1.3
    meson-python # >= 0.18
    ninja # >= 1.10
    numpy # >= 2.0
  ];

  nativeBuildInputs = [
    gfortran
    pkg-config
  ];

  buildInputs = [ openblas ];

  dependencies = [
    numpy # >= 2.0
    scipy # >= 1.13
    meshio # >= 5.3.5
    msgspec # >= 0.20
    matplotlib # >= 3.8.4
    jinja2 # >= 3.1
    rich # >= 13
    threadpoolctl # >= 3.1
  ];

  pythonImportsCheck = [ "flankload" ];

  meta = {
    description = "Load distribution on the flanks of two elastic bodies that turn about parallel axes";
    license = lib.licenses.bsd3;
    mainProgram = "flankload";
    platforms = lib.platforms.unix;
  };
}
