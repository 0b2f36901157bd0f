recursion 5
angle 25.5
thickness 12
min_thickness 1
shape 4
switch_yz 0
axiom F[+(90)A]%
rule A = F<c(3)A
