#pragma once

#include <string>

#include "tests/models/fmu/test_fmu.h"

namespace lithe::test {

/// The FMU of servo.cpp.
class ServoFmu : public TestFmu {
 public:
  explicit ServoFmu(int version) : TestFmu(version, "servo", LITHE_TEST_SERVO, description(version)) {}
  static std::string description(int version);
  std::string packed() const { return TestFmu::packed("servo"); }
};

inline std::string ServoFmu::description(int version) {
  const std::string two = R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Servo" guid="servo-1" generationTool="a text editor">
  <CoSimulation modelIdentifier="servo" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true"
                canSerializeFMUstate="true"/>
  <TypeDefinitions><SimpleType name="Angle"><Real unit="rad"/></SimpleType></TypeDefinitions>
  <DefaultExperiment stepSize="0.01"/>
  <ModelVariables>
    <ScalarVariable name="angle" valueReference="0" causality="input"><Real start="0" declaredType="Angle"/></ScalarVariable>
    <ScalarVariable name="target" valueReference="1" causality="input"><Real start="0" unit="rad"/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="2" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="integral_gain" valueReference="3" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="torque" valueReference="4" causality="output"><Real unit="N.m"/></ScalarVariable>
    <ScalarVariable name="integral" valueReference="5" causality="local"><Real/></ScalarVariable>
    <ScalarVariable name="enabled" valueReference="6" causality="input"><Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="7" causality="parameter" variability="tunable"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="note" valueReference="8" causality="parameter" variability="fixed"><String start="none"/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>
)";
  const std::string three = R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Servo" instantiationToken="servo-1">
  <CoSimulation modelIdentifier="servo" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true"
                canSerializeFMUState="true"/>
  <DefaultExperiment stepSize="0.01"/>
  <ModelVariables>
    <Float64 name="angle" valueReference="0" causality="input" start="0" unit="rad"/>
    <Float64 name="target" valueReference="1" causality="input" start="0"/>
    <Float64 name="gain" valueReference="2" causality="parameter" variability="fixed" start="1"/>
    <Float64 name="integral_gain" valueReference="3" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="torque" valueReference="4" causality="output"/>
    <Float64 name="integral" valueReference="5" causality="local"/>
    <Boolean name="enabled" valueReference="6" causality="input" start="true"/>
    <Int32 name="fault" valueReference="7" causality="parameter" variability="tunable" start="0"/>
    <Float64 name="gains" valueReference="8" causality="parameter" start="1 2 3"><Dimension start="3"/></Float64>
  </ModelVariables>
</fmiModelDescription>
)";
  return version == 2 ? two : three;
}

}  // namespace lithe::test
