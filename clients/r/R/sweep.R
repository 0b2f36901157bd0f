# A model as a function of its parameters, from R: `espalier sweep` makes the runs (docs/sweeps.md).
#
#   source("clients/r/R/sweep.R")   # or library(espalier)
#   sets <- data.frame(ETA = c(0.8, 0.9), LAMBDA = 0.7)
#   espalier_run("borchert-honda", sets, '{"tips": {"count": "A"}, "height": {"plant": "height"}}')

# The measures of every row of `parameters` (a data frame; a column `seed` gives seeds), as a data frame with the columns
# run, seed, the parameters, the measures and error. `measures`: the member of a plan, as JSON text. `more`: further members of
# the plan as JSON text, as '"steps": 120'.
espalier_run <- function(model, parameters, measures, more = "",
                         program = Sys.getenv("ESPALIER_PROGRAM", "espalier")) {
  folder <- tempfile("espalier-")
  dir.create(folder)
  on.exit(unlink(folder, recursive = TRUE))
  file <- function(name) file.path(folder, name)
  write.table(format(parameters, digits = 17, trim = TRUE), file("runs.csv"), sep = ",", quote = FALSE, row.names = FALSE)
  if (file.exists(model)) model <- normalizePath(model)
  writeLines(sprintf('{"model": %s, "runs": {"table": "runs.csv"}, "measures": %s%s}', encodeString(model, quote = '"'),
                     measures, if (nzchar(more)) paste0(", ", more) else ""), file("plan.json"))
  for (arguments in list(c("sweep", file("plan.json"), "-o", file("r.sqlite"), "--quiet"),
                         c("sweep", "export", file("r.sqlite"), "-o", file("r.csv")))) {
    said <- suppressWarnings(system2(program, shQuote(arguments), stdout = TRUE, stderr = TRUE))
    status <- attr(said, "status")
    if (!is.null(status) && status != 0) stop(paste(said, collapse = "\n"), call. = FALSE)
  }
  read.csv(file("r.csv"), colClasses = c(error = "character"), check.names = FALSE)
}
