line style: cylinder
initial line width: 0.3 s
contour sides: 12
initial color: 255
texture: F bark.png H l L m E m R 2
texture: F leaf.png H l L m E m S
surface: l leaf.s 1
viewpoint: 0.4,0.25,1
