-1 1   0 4   0 0.5
PRECISION S: 4 T: 4
CONTACT POINT  X: 0 Y: 0 Z: 0
END POINT  X: 0 Y: 4 Z: 0
HEADING  X: 0 Y: 1 Z: 0
UP  X: 0 Y: 0 Z: 1
SIZE: 4
blade
TOP COLOR: 0 DIFFUSE: 0 BOTTOM COLOR: 0 DIFFUSE: 0
AL: ~ A: ~ AR: ~
L: ~ R: ~
BL: ~ B: ~ BR: ~
0 0 0  0 0 0  0 0 0  0 0 0
-1 1 0.2  -0.3 1 0  0.3 1 0  1 1 0.2
-1 3 0.2  -0.3 3 0  0.3 3 0  1 3 0.2
 0 4 0   0 4 0    0 4 0    0 4 0
