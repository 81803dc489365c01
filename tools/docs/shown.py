"""Every public class and every struct of options is shown by code that compiles: shown.py LITHE_H, the generated
lithe/lithe.h.

The code is that of examples/, of docs/site/code and of the pages' blocks that are compiled or cut from tested sources
(code_blocks.py). A type is shown where its name stands there, or a function is called that returns it. A struct is also
shown where one of its fields is used and a function that is called takes it, or a field that is used holds it. What no
scene names stands below with the reason.
"""

import pathlib
import re
import sys

import code_blocks

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "catalogue"))
import headers

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODE = ("examples/**/*.cpp", "examples/**/*.h", "docs/site/code/*.cpp")
EXCEPTIONS = {
    "what bodies, joints and forces of one's own derive from or are told, beyond what extend/ shows": """
        ConfigurationOf MotionOf Element Connector ContactElement DeformableBody PlanarBody PointBody
        RigidFrameBody ScalarBody RigidInertia RigidRows DrawableBody DrawableConnector DrawnMesh DrawnSkin
        FramePair AngleMemory ActingMarkers CoupledMarkers CoordinateSwitch EventMemory MarkerLoad
        MarkerMotions MeasuredCoordinate DeflectedMarker MarkerBetween InputEffort CoordinateEffort
        InternalLoads FrictionByImpulses BristleLaw FrictionLaw StribeckLaw JointSurface LimitedDamping Parameter
        Spatial ForwardDynamics ComplexFactor ComplexTangentWeights HeldCoordinates GaussRule
        LimitedMotion""",
    "what batches of elements hand to each other": """
        BatchRange""",
    "what contact and its detection hand to each other": """
        ContactSide ContactPoses ContactDetector ContactTrace CompliantMemory CapsulePiece""",
    "elements that a function or a body draws: the page of that shows it": """
        BeamElement LineLoadPiece LinePiece RailCurve RailMarkers RollingBearing HertzPoint SpinningBall SeparatedLift
        GearGeometry GearPhase InvoluteGear BevelCone SprocketRun ControlProgram""",
    "what a flexible body is made of; make_basis() and the readers fill it": """
        BeamMesh DeflectionMap FlexibleInertia ModalInertia NodalInertia FramePlacement FreeMotions
        InertiaEffect InertiaGroup LoadGeometry NodeAverage QuadraticDeflection RotationalDof SelectedBasis
        SolidPoint SparseCholesky StiffnessDifference StressStiffness DeformationFields Definiteness""",
    "parts of the readers, which read_flexible_body() and read_model() call": """
        BodyFormat BodyOpening FoundBody UnitEvidence CalculixDeck Op4Matrix SidFile AdamsCurve AdamsMeasure
        AdamsNames ModelLink ModelJoint ModelNote""",
    "needs an FMU: tests/models/fmu/imported_fmu_test.cpp": """
        ImportedFmu""",
    "parts of integrators": """
        AlphaRecord BdfHistory BdfRecord ContactImpulses JointFrictionImpulses MomentumBalance RadauStages ReactionStates
        RungeKuttaStep StabilizedIndex2 StaticFriction""",
    "parts of runs, studies, gradients and plug-ins": """
        CheckpointSchedule SceneFingerprint FollowedSimulation Kink ObserverSchedules RowSpace FreeMotion
        CertificateCost CertificateTrial DrivenOscillators Progress Sampling SolveMethods StudySystem
        TextTable Drawing ErrorText Export IntegratorType PluginLibrary PluginObject PluginType Views
        Hdf5Series PartialFile ResourceFolder ThreadTeam""",
    "written as a text or in braces": """
        Located SweepValue""",
}


def public_types(lithe_h):
    for line in pathlib.Path(lithe_h).read_text().splitlines():
        if line.startswith('#include "'):
            header = line.split('"')[1]
            yield from headers.types_of(ROOT / header, header)


def compiled_code():
    texts = [path.read_text() for pattern in CODE for path in sorted(ROOT.glob(pattern))]
    texts += [block.text for block in code_blocks.all_blocks()
              if block.language in code_blocks.CPP and code_blocks.judge(block)[0] in ("cut", "compiled", "run by")]
    return headers.without_comments("\n".join(texts))


def handed_over(types):
    """{type: functions that take or return it and fields that hold it}, and {type: functions that return it}."""
    paths = [ROOT / header for header in sorted({type_.header for type_ in types})]
    text = "\n".join(headers.without_comments(path.read_text()) for path in paths)
    found, made = {}, {}
    for statement in re.split(r"[;{}]", re.sub(r" = \{[^{}]*\}", "", text)):
        line = " ".join(statement.split())
        for name in set(re.findall(r"\b[A-Z]\w+", line)):
            found.setdefault(name, set()).update(re.findall(r"\b(\w+)\(", line)[:1])
            returns = rf"^(?:\[\[nodiscard\]\] |inline |const |std::\w+<)*{name}[&>]* (\w+)\("
            made.setdefault(name, set()).update(re.findall(returns, line))
            held = re.search(rf"\b{name}(?:>|&|\*)* ([a-z]\w*)(?: = .*)?$", line)
            if held:
                found[name].add("." + held[1])
    return found, made


def fields(type_):
    type_of_field, others, default = r"(?:[\w:]+(?:<[^;()]*>)?[&*]? +)", r"(?:\w+(?: = [^;,]*)?, )*", r"(?: = [^;]*|\{[^;]*\})?"
    return re.findall(rf"^ +{type_of_field}{others}(\w+){default};", type_.body, re.M)


def unshown(types, code):
    words = set(re.findall(r"\w+", code))
    used = set(re.findall(r"(?:\.|->)\s*(\w+)\b(?!\s*\()", code))
    hands, made = handed_over(types)
    for type_ in types:
        if type_.name in words:
            continue
        over = hands.get(type_.name, set())
        by = any(name[1:] in used if name.startswith(".") else name in words for name in over)
        if made.get(type_.name, set()) & words:
            continue
        if type_.kind == "struct" and by and any(field in used for field in fields(type_)):
            continue
        yield type_


def main():
    types = [type_ for type_ in public_types(sys.argv[1]) if "batch_of.h" not in type_.header]
    excepted = {name: reason for reason, names in EXCEPTIONS.items() for name in names.split()}
    missing = list(unshown(types, compiled_code()))
    wrong = [f"no code that compiles shows {type_.name}\n  at:   {type_.header}\n  fix:  an example on its page, or a "
             "reason in tools/docs/shown.py" for type_ in missing if type_.name not in excepted]
    wrong += [f"{name} is shown, or is no public type\n  at:   tools/docs/shown.py\n  fix:  take it out of EXCEPTIONS"
              for name in sorted(excepted.keys() - {type_.name for type_ in missing})]
    for error in wrong:
        print(f"error: {error}", file=sys.stderr)
    print(f"{len(types)} public types, {len(types) - len(missing)} shown, {len(missing)} with a reason" if not wrong
          else f"{len(wrong)} errors")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
