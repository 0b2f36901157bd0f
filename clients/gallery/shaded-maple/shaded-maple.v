angle increment: 45
initial line width: 0.6 s
initial color: 1
line style: cylinder
viewpoint: 6,6,24
view reference point: 0,8,0
projection: parallel
render mode: shaded
light: V: 1,2,2 D: 1,1,1
light: V: -1,1,0 D: 0.3,0.3,0.4
