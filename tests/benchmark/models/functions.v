function: growth.func
function: shrink.func
