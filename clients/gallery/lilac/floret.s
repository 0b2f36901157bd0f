-0.4 0.4 0 1 -0.2 0.2
PRECISION S: 4 T: 4
CONTACT POINT  X: 0 Y: 0 Z: 0
END POINT  X: 0 Y: 0 Z: 0
HEADING  X: 0 Y: 1 Z: 0
UP  X: 0 Y: 0 Z: -1
SIZE: 1
petal
TOP COLOR: 0 DIFFUSE: 0 BOTTOM COLOR: 0 DIFFUSE: 0
AL: ~ A: ~ AR: ~
L: ~ R: ~
BL: ~ B: ~ BR: ~
 0 0 0  0 0 0  0 0 0  0 0 0
-0.28 0.05 -0.5  -0.09 0.05 -0.62  0.09 0.05 -0.62  0.28 0.05 -0.5
-0.34 0.08 -0.9  -0.1 0.02 -1.0  0.1 0.02 -1.0  0.34 0.08 -0.9
-0.02 0.2 -1.1  0 0.2 -1.15  0 0.2 -1.15  0.02 0.2 -1.1
