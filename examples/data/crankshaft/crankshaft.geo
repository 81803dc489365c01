// One throw of a crankshaft with its two main journals, metres: axis along z, crank pin at x = 43 mm.
// gmsh -3 crankshaft.geo -o crankshaft.msh; coordinates rounded to 1e-8 m.
SetFactory("OpenCASCADE");
throw = 0.043; pin = 0.023; journal = 0.026;           // radii
half_pin = 0.013; web = 0.018; bearing = 0.028;        // along the axis
fillet = 0.004; cheek = 0.034; weight = 0.062;

Cylinder(1) = {throw, 0, -half_pin, 0, 0, 2 * half_pin, pin};
z = half_pin + web;
Cylinder(2) = {0, 0, z, 0, 0, bearing, journal};
Cylinder(3) = {0, 0, -z - bearing, 0, 0, bearing, journal};
For side In {0:1}
  base = 10 + 10 * side;
  from = side == 0 ? half_pin : -half_pin - web;
  Cylinder(base) = {throw, 0, from, 0, 0, web, cheek};
  Box(base + 1) = {-0.01, -cheek, from, throw + 0.01, 2 * cheek, web};
  Cylinder(base + 2) = {0, 0, from, 0, 0, web, weight};
  Box(base + 3) = {-weight, -weight, from, weight - 0.01, 2 * weight, web};
  BooleanIntersection(base + 4) = { Volume{base + 2}; Delete; }{ Volume{base + 3}; Delete; };
EndFor
BooleanUnion(30) = { Volume{1}; Delete; }{ Volume{2, 3, 10, 11, 14, 20, 21, 24}; Delete; };

e = 1e-4;
rims() = Curve In BoundingBox {throw - pin - e, -pin - e, half_pin - e, throw + pin + e, pin + e, half_pin + e};
rims() += Curve In BoundingBox {throw - pin - e, -pin - e, -half_pin - e, throw + pin + e, pin + e, -half_pin + e};
rims() += Curve In BoundingBox {-journal - e, -journal - e, z - e, journal + e, journal + e, z + e};
rims() += Curve In BoundingBox {-journal - e, -journal - e, -z - e, journal + e, journal + e, -z + e};
Fillet{30}{rims()}{fillet}

Physical Volume("crankshaft") = Volume{:};
w = half_pin - fillet;
Physical Surface("pin") = Surface In BoundingBox {throw - pin - e, -pin - e, -w - e, throw + pin + e, pin + e, w + e};
Physical Surface("front") = Surface In BoundingBox
  {-journal - e, -journal - e, -z - bearing - e, journal + e, journal + e, -z - fillet + e};
Physical Surface("rear") = Surface In BoundingBox
  {-journal - e, -journal - e, z + fillet - e, journal + e, journal + e, z + bearing + e};

// Finer in the fillets of the pin on the inner side, where they are stressed most.
For side In {0:1}
  Field[side + 1] = Box;
  Field[side + 1].VIn = 0.0037; Field[side + 1].VOut = 0.025; Field[side + 1].Thickness = 0.004;
  Field[side + 1].XMin = throw - pin - 2 * fillet; Field[side + 1].XMax = throw - pin / 2;
  Field[side + 1].YMin = -0.02; Field[side + 1].YMax = 0.02;
  from = side == 0 ? half_pin - fillet : -half_pin;
  Field[side + 1].ZMin = from; Field[side + 1].ZMax = from + fillet;
EndFor
Field[3] = Min;
Field[3].FieldsList = {1, 2};
Background Field = 3;
Mesh.MeshSizeMin = 0.003;
Mesh.MeshSizeMax = 0.025;
Mesh.MeshSizeFromCurvature = 4;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 1;
Mesh.MshFileVersion = 2.2;
