# A light model in R as an environment of an Espalier server: Rscript light.R HOST PORT
# By Beer's law the light at a point falls with the number of queries (buds) above it in a column 0.6 m wide.
script <- sub("--file=", "", grep("--file=", commandArgs(), value = TRUE))
source_file <- file.path(dirname(script), "..", "R", "espalier.R")
if (file.exists(source_file)) source(source_file) else library(espalier)

light <- function(queries) {
  column <- paste(floor(queries$x / 0.6), floor(queries$z / 0.6))
  above <- ave(queries$y, column, FUN = function(y) rank(-y, ties.method = "min") - 1)
  exp(-0.15 * above)
}

arguments <- commandArgs(trailingOnly = TRUE)
attach_environment("r-light", paste(arguments, collapse = ":"), light)
