executable: honda81 -e branch-tiers.e branch-tiers.spec
turtle position: P: %.9g %.9g %.9g
