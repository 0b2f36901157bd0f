line style: cylinder
initial line width: 0.2 s
contour sides: 10
texture: F bark.png H l L m R 2
texture: F bark.rgb E d
texture: F leaf.png H l L m S
surface: l leaf.s 1
