// own_pinion.geo: one sector of the FZG type C pinion, its working flank where it is at position zero
SetFactory("Built-in");
z = 16;  m = 4.5;  alpha = 20*Pi/180;  shift = 0.182;
bore = 15;  root = 31.2;  form = 34;  tip = 41.23;  pitch = 36.6;     // radii in mm
base = m*z/2*Cos(alpha);
half = Pi/(2*z) + 2*shift*Tan(alpha)/z + Tan(alpha) - alpha;           // half tooth on the base circle

// Angle between the tooth's centre line and the involute at the radius r: half - inv(acos(base/r))
a = Acos(base/pitch);
centre = -(half - (Tan(a) - a));    // the flank passes through the pitch point on the x axis
n = 12;
For i In {0:n}
  r = form + (tip - form)*i/n;
  a = Acos(base/r);
  t = half - (Tan(a) - a);
  Point(100 + i) = {r*Cos(centre + t), r*Sin(centre + t), 0};          // working flank
  Point(200 + i) = {r*Cos(centre - t), r*Sin(centre - t), 0};          // coast flank
EndFor
For side In {0:1}
  s = 1 - 2*side;
  cut = centre + s*Pi/z;
  a = Acos(base/form);
  t = centre + s*(half - (Tan(a) - a));
  Point(10 + side) = {bore*Cos(cut), bore*Sin(cut), 0};
  Point(20 + side) = {root*Cos(cut), root*Sin(cut), 0};
  Point(30 + side) = {(root + 0.3)*Cos(t + s*0.012), (root + 0.3)*Sin(t + s*0.012), 0};
EndFor
Point(1) = {0, 0, 0};
Circle(1) = {11, 1, 10};                 // bore
Line(2) = {10, 20};                      // cut towards the next tooth
BSpline(3) = {20, 30, 100};              // fillet
Spline(4) = {100:112};                   // working flank
Circle(5) = {112, 1, 212};               // tip
Spline(6) = {212:200:-1};                // coast flank
BSpline(7) = {200, 31, 21};              // fillet
Line(8) = {21, 11};                      // cut
Curve Loop(1) = {1:8};
Plane Surface(1) = {1};
Periodic Curve {8} = {-2} Rotate {{0, 0, 1}, {0, 0, 0}, -2*Pi/z};      // both cuts have the same nodes

Transfinite Curve {4} = 25;
Transfinite Curve {6} = 13;
Transfinite Curve {3, 7} = 7;
Transfinite Curve {5} = 6;
Transfinite Curve {2} = 9 Using Progression 0.8;
Transfinite Curve {1} = 4;
Mesh.ElementOrder = 2;
Mesh.Algorithm = 5;

Physical Surface("STEEL") = {1};
Physical Curve("FLANK") = {4};
Physical Curve("BORE") = {1};
Physical Curve("CUT_LEFT") = {2};
Physical Curve("CUT_RIGHT") = {8};
