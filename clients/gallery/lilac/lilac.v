/* a portrait from the front, a little above */
angle factor: 8
initial color: 8
color increment: 1
initial line width: 0.3 p
line style: cylinder
line width increment: 0
viewpoint: 0.5,0.35,1.6
view reference point: 0,0,0
projection: parallel
scale factor: 0.9
render mode: shaded
z buffer: on
light direction: 1,2,2
diffuse reflection: 0
surface: l leaf.s 1
surface: f floret.s 1
function: height.func
function: width.func
