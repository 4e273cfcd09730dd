"""The tables of a whole scene file, and the rules between the tables.

The reader (`form`) and the JSON schema are both made from these tables, which define every key
once with its type, range, unit and meaning.
"""

from collections.abc import Mapping
from typing import Annotated, Any

from flankload.scene.accuracy import Accuracy
from flankload.scene.axial import check_dimension
from flankload.scene.belt import Belt, Pulley
from flankload.scene.cam import Cam, Follower
from flankload.scene.chain import Chain, Sprocket
from flankload.scene.drive import check_drive
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.effects.rules import check_effects
from flankload.scene.gear import Gear, Ring
from flankload.scene.mesh import ComplianceBody, MeshBody
from flankload.scene.pair import Load, Pair, Positions, check_partners
from flankload.scene.refusal import refuse
from flankload.scene.spline import SplineHub, SplineShaft
from flankload.scene.table import Table, Text, about

Body1 = Gear | SplineShaft | Follower | Sprocket | Pulley | MeshBody | ComplianceBody
Body2 = Gear | Ring | SplineHub | Cam | Chain | Belt | MeshBody | ComplianceBody
BodySpec = Body1 | Body2


class SceneFile(Table, frozen=True, kw_only=True):
    """A scene file."""

    name: Annotated[Text | None, about("name of the scene; absent = name of the file")] = None
    body_1: Annotated[Body1, about("the body that carries the torque; free to rotate")]
    body_2: Annotated[Body2, about("the body that is fixed at its kinematic angle")]
    pair: Annotated[
        Pair | None, about("required, except for chains and belts, which do not have this table")
    ] = None
    load: Load
    positions: Positions = Positions()
    effects: EffectsAsked = EffectsAsked()
    accuracy: Accuracy = Accuracy()

    def check(self, given: Mapping[str, Any]) -> None:
        """Check the rules between the tables; `given` is the scene as in the file.

        Raises
        ------
        SceneError
            At the first key that contradicts another one; names key, expected and found.
        """
        check_partners(self.body_1, self.body_2)
        check_drive(self, given)
        if self.pair is not None:
            self.pair.check(self.body_1, self.body_2)
        check_dimension(self, given)
        check_effects(self, given)
        self.positions.check(given.get("positions", {}))
        if any(self.load.torques_Nm) and self.body_1.rigid and self.body_2.rigid:
            refuse(
                "body_2.rigid",
                "false, since body_1.rigid is true: the load sharing of two rigid bodies "
                "is undetermined",
                True,
            )
