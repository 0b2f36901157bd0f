# A light model in R as an environment of an Espalier server: Rscript light.R HOST PORT
# By Beer's law the light at a point falls with the number of queries (buds) above it in a column 0.6 m wide.
arguments <- commandArgs(trailingOnly = TRUE)
server <- socketConnection(arguments[1], as.integer(arguments[2]), open = "r+b", blocking = TRUE, timeout = 3600)
say <- function(...) writeLines(paste0('{"jsonrpc":"2.0",', ..., "}"), server)
answer <- function(id, result) say('"id":', id, ',"result":', result)

# the text or number behind a key of a JSON line
value <- function(line, key) sub(sprintf('.*?"%s":("[^"]*"|[-+.0-9eE]+).*', key), "\\1", line, perl = TRUE)
# all of them, for lists of queries
values <- function(line, pattern) regmatches(line, gregexpr(pattern, line, perl = TRUE))[[1]]

# a server with tokens wants one: ESPALIER_TOKEN=… Rscript light.R HOST PORT
token <- Sys.getenv("ESPALIER_TOKEN")
say('"id":1,"method":"hello","params":{"protocol":[1],"roles":["environment"],"name":"r-light","version":"1"',
    if (nzchar(token)) paste0(',"token":"', token, '"'), "}")
invisible(readLines(server, 1))
say('"id":2,"method":"environment.offer","params":{"name":"r-light"}')
invisible(readLines(server, 1))
message("r-light is offered")

while (length(line <- readLines(server, 1)) == 1) {
  id <- value(line, "id")
  switch(gsub('"', "", value(line, "method")),
    environment.describe = answer(id, paste0('{"name":"r-light","needs":["position"],',
                                             '"outputs":[{"name":"light","unit":"1"}]}')),
    environment.step = {
      queries <- values(line, '(?<=\\{"id":)[0-9]+(?=,"plant")')
      if (length(queries) == 0) {  # a step without queries needs an answer too
        answer(id, '{"replies":[]}')
        next
      }
      points <- do.call(rbind, lapply(strsplit(values(line, '(?<="position":\\[)[^]]*'), ","), as.numeric))
      column <- paste(floor(points[, 1] / 0.6), floor(points[, 3] / 0.6))
      above <- ave(points[, 2], column, FUN = function(y) rank(-y, ties.method = "min") - 1)
      light <- formatC(exp(-0.15 * above), digits = 17, format = "g")
      answer(id, paste0('{"replies":[', paste0('{"id":', queries, ',"parameters":[', light, "]}", collapse = ","), "]}"))
    },
    if (id != line) answer(id, "{}"))  # open, close: nothing to do
}
