// Angle bracket of tests/data/bracket in coarser elements, metres: a base with two bolt holes, an upright with one.
// gmsh -3 bracket.geo -o bracket.msh
SetFactory("OpenCASCADE");
length = 0.08; height = 0.07; width = 0.04; thickness = 0.008; fillet = 0.012;
bolt = 0.0045; eye = 0.008;

// Profile in the x-z plane, swept along y.
Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
Point(3) = {length, 0, thickness};
Point(4) = {thickness + fillet, 0, thickness};
Point(5) = {thickness + fillet, 0, thickness + fillet};
Point(6) = {thickness, 0, thickness + fillet};
Point(7) = {thickness, 0, height};
Point(8) = {0, 0, height};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4};
Circle(4) = {4, 5, 6};
Line(5) = {6, 7}; Line(6) = {7, 8}; Line(7) = {8, 1};
Curve Loop(1) = {1, 2, 3, 4, 5, 6, 7};
Plane Surface(1) = {1};
Extrude {0, width, 0} { Surface{1}; }

Cylinder(2) = {0.04, width / 2, -0.001, 0, 0, 0.01, bolt};
Cylinder(3) = {0.065, width / 2, -0.001, 0, 0, 0.01, bolt};
Cylinder(4) = {-0.001, width / 2, 0.05, 0.01, 0, 0, eye};
BooleanDifference(5) = { Volume{1}; Delete; }{ Volume{2, 3, 4}; Delete; };

e = 1e-6;
Physical Volume("bracket") = {5};
Physical Surface("back") = Surface In BoundingBox {-e, -e, -e, e, width + e, height + e};
Physical Surface("eye") = Surface In BoundingBox
  {-e, width / 2 - eye - e, 0.05 - eye - e, thickness + e, width / 2 + eye + e, 0.05 + eye + e};
Physical Surface("bolt_1") = Surface In BoundingBox
  {0.04 - bolt - e, width / 2 - bolt - e, -e, 0.04 + bolt + e, width / 2 + bolt + e, thickness + e};
Physical Surface("bolt_2") = Surface In BoundingBox
  {0.065 - bolt - e, width / 2 - bolt - e, -e, 0.065 + bolt + e, width / 2 + bolt + e, thickness + e};

Mesh.MeshSizeMin = 0.004;
Mesh.MeshSizeMax = 0.011;
Mesh.MeshSizeFromCurvature = 6;
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 1;
Mesh.MshFileVersion = 2.2;
