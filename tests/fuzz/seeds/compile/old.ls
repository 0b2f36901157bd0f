# a fern
5
25.5 # angle
12
F[+(90)A]%
A=F<c(3)A
@
