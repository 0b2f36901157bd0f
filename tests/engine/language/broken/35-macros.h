#define LIMIT 3 + *2
#define GROW(l) (l * growthRate)
