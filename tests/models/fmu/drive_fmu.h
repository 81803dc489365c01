#pragma once

#include <string>

#include "tests/models/fmu/test_fmu.h"

namespace lithe::test {

inline const std::string kDrive2 = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Drive" guid="drive" generationTool="a text editor" numberOfEventIndicators="0">
  <ModelExchange modelIdentifier="Drive" canGetAndSetFMUstate="true" canSerializeFMUstate="true" providesDirectionalDerivative="true"/>
  <ModelVariables>
    <ScalarVariable name="motion[1]" valueReference="1" causality="input" variability="continuous"><Real start="0" unit="rad"/></ScalarVariable>
    <ScalarVariable name="motion[2]" valueReference="2" causality="input" variability="continuous"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="target" valueReference="3" causality="input" variability="continuous"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="torque" valueReference="4" causality="output" variability="continuous"><Real unit="N.m"/></ScalarVariable>
    <ScalarVariable name="integral" valueReference="5" causality="local" variability="continuous" initial="exact"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="der(integral)" valueReference="6" causality="local" variability="continuous"><Real derivative="5"/></ScalarVariable>
    <ScalarVariable name="gains[1]" valueReference="7" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="gains[2]" valueReference="8" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="gains[3]" valueReference="9" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="current" valueReference="10" causality="local" variability="continuous" initial="exact"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="der(current)" valueReference="11" causality="local" variability="continuous"><Real derivative="10"/></ScalarVariable>
    <ScalarVariable name="lag" valueReference="12" causality="parameter" variability="fixed"><Real start="0" unit="s"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="13" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="switch" valueReference="13" causality="input" variability="discrete"><Integer start="0"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="4"/></Outputs>
    <Derivatives><Unknown index="6"/><Unknown index="11"/></Derivatives>
  </ModelStructure>
</fmiModelDescription>
)xml";
inline const std::string kDrive3 = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Drive" instantiationToken="drive" generationTool="a text editor">
  <ModelExchange modelIdentifier="Drive" canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true"/>
  <ModelVariables>
    <Float64 name="motion" valueReference="1" causality="input" start="0"><Dimension start="2"/></Float64>
    <Float64 name="target" valueReference="3" causality="input" start="0"/>
    <Float64 name="torque" valueReference="4" causality="output" unit="N.m"/>
    <Float64 name="integral" valueReference="5" start="0"/>
    <Float64 name="der(integral)" valueReference="6" derivative="5"/>
    <UInt64 name="count" valueReference="14" causality="structuralParameter" variability="fixed" start="3"/>
    <Float64 name="gains" valueReference="7" causality="parameter" variability="fixed" start="1 0 0"><Dimension valueReference="14"/></Float64>
    <Float64 name="current" valueReference="10" start="0"/>
    <Float64 name="der(current)" valueReference="11" derivative="10"/>
    <Float64 name="lag" valueReference="12" causality="parameter" variability="fixed" start="0"/>
    <Int32 name="fault" valueReference="13" causality="parameter" variability="fixed" start="0"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="4"/>
    <ContinuousStateDerivative valueReference="6"/>
    <ContinuousStateDerivative valueReference="11"/>
  </ModelStructure>
</fmiModelDescription>
)xml";
/// A controller with an integral and a slow amplifier: Drive of tests/data/fmi/equations.cpp.
inline TestFmu drive_fmu(int version) {
  return {version, "Drive", LITHE_TEST_EQUATIONS "Drive.so", version == 2 ? kDrive2 : kDrive3};
}

}  // namespace lithe::test
