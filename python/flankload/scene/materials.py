"""Materials by name: elastic constants, thermal expansion and density at 23 degrees Celsius."""

from typing import Annotated, Literal, NamedTuple

from flankload.scene.table import about


class NamedMaterial(NamedTuple):
    """A material that a body can name.

    Attributes
    ----------
    young_modulus_MPa, poisson_ratio, thermal_expansion_per_K, density_kg_m3 : float
    source : str
        Standard or data sheet of the values.
    """

    young_modulus_MPa: float
    poisson_ratio: float
    thermal_expansion_per_K: float
    density_kg_m3: float
    source: str


MATERIALS = {
    "steel": NamedMaterial(206000.0, 0.3, 11.5e-6, 7850.0, "ISO 6336-2"),
    "cast_steel": NamedMaterial(202000.0, 0.3, 11.5e-6, 7850.0, "ISO 6336-2"),
    "sintered_steel": NamedMaterial(
        140000.0, 0.27, 11.5e-6, 6950.0, "MPIF Standard 35, FD-0408-55, 6.95 g/cm^3"
    ),
    "cast_iron": NamedMaterial(118000.0, 0.26, 11.7e-6, 7200.0, "ISO 6336-2, EN 1561 (GJL-250)"),
    "ductile_iron": NamedMaterial(173000.0, 0.275, 12.5e-6, 7100.0, "ISO 6336-2, EN 1563"),
    "bronze": NamedMaterial(113000.0, 0.3, 17.5e-6, 8800.0, "ISO 6336-2 (tin bronze)"),
    "aluminium": NamedMaterial(70000.0, 0.3, 23e-6, 2700.0, "EN 1999-1-1"),
    "POM": NamedMaterial(2855.0, 0.35, 1.2e-4, 1390.0, "data sheet of POM-C, ISO 527, 23 C"),
    "PA66": NamedMaterial(
        1400.0, 0.4, 1e-4, 1140.0, "data sheet of PA66, ISO 527, conditioned at 23 C and 50 % RH"
    ),
}
#: Keys of a body that follow from its material.
ELASTIC_KEYS = ("young_modulus_MPa", "poisson_ratio")
#: Keys of [effects] that follow from the materials of both bodies, with the key that uses each.
EFFECT_KEYS = {"thermal_expansion_per_K": "temperature_rise_K", "density_kg_m3": "speed_rpm"}

MaterialName = Annotated[
    Literal[
        "steel",
        "cast_steel",
        "sintered_steel",
        "cast_iron",
        "ductile_iron",
        "bronze",
        "aluminium",
        "POM",
        "PA66",
    ]
    | None,
    about(
        "material by name (docs/guide/catalogues.md): Young's modulus, Poisson's ratio and, where "
        "effects use them, thermal expansion and density; keys that the scene sets have "
        "precedence"
    ),
]
