# Environments for Espalier plants in base R: a function of all queries of a step, offered to a running server.
#
#   source("clients/r/R/espalier.R")   # or library(espalier)
#   attach_environment("height", "127.0.0.1:4321", function(queries) queries$y)

# the text or number behind a key of a JSON line
json_value <- function(line, key) {
  sub(sprintf('.*?"%s":("[^"]*"|[-+.0-9eE]+).*', key), "\\1", line, perl = TRUE)
}

# all matches of a pattern, in order
json_all <- function(line, pattern) regmatches(line, gregexpr(pattern, line, perl = TRUE))[[1]]

# the queries of a step: id, x, y, z, and p1, p2, ... (the parameters of the module, NA where it has fewer)
read_queries <- function(line) {
  id <- json_all(line, '(?<=\\{"id":)[0-9]+(?=,"plant")')
  numbers <- function(pattern) lapply(strsplit(json_all(line, pattern), ","), as.numeric)
  place <- numbers('(?<="position":\\[)[^]]*')
  parameters <- numbers('(?<="parameters":\\[)[^]]*')
  queries <- data.frame(id = id, stringsAsFactors = FALSE)
  for (axis in 1:3) queries[[c("x", "y", "z")[axis]]] <- vapply(place, function(row) row[axis], 0)
  for (i in seq_len(max(0, lengths(parameters)))) queries[[paste0("p", i)]] <- vapply(parameters, function(row) row[i], 0)
  queries
}

# the replies of a vector (one number for each query) or of a matrix (a row of numbers for each)
write_replies <- function(queries, answer) {
  answer <- as.matrix(answer)
  if (nrow(answer) != nrow(queries)) stop(sprintf("%d answers for %d queries", nrow(answer), nrow(queries)))
  if (any(!is.finite(answer))) stop("an answer is not a finite number")
  numbers <- apply(answer, 1, function(row) paste(formatC(row, digits = 17, format = "g"), collapse = ","))
  paste0('{"replies":[', paste0('{"id":', queries$id, ',"parameters":[', numbers, "]}", collapse = ","), "]}")
}

# a sentence as a JSON text
json_text <- function(text) paste0('"', gsub("[[:cntrl:]]", " ", gsub('["\\\\]', "'", text)), '"')

# the answer to a step: warnings of the function are notes, which the user of the simulation reads
answer_step <- function(queries, respond) {
  if (nrow(queries) == 0) return('{"replies":[]}')
  notes <- character()
  answer <- withCallingHandlers(respond(queries), warning = function(said) {
    notes <<- c(notes, json_text(conditionMessage(said)))
    invokeRestart("muffleWarning")
  })
  paste0('{"notes":[', paste(notes, collapse = ","), "],", sub("{", "", write_replies(queries, answer), fixed = TRUE))
}

# Offers a function as the environment `name` to a server (HOST:PORT) and answers until the server ends. `respond` gets
# a data frame with one row for each query and returns a number, or a row of numbers, for each row. An error in it fails
# the step; the simulation stays at its last completed step. A `warning()` in it is said once to the user of the
# simulation. A server with tokens wants one: ESPALIER_TOKEN has it.
attach_environment <- function(name, address, respond, token = Sys.getenv("ESPALIER_TOKEN")) {
  parts <- regmatches(address, regexec("^(.*):([0-9]+)$", address))[[1]]
  if (length(parts) != 3) stop(sprintf("'%s' is not an address; write HOST:PORT, as in 127.0.0.1:4321", address))
  server <- tryCatch(
    suppressWarnings(socketConnection(parts[2], as.integer(parts[3]), open = "r+b", blocking = TRUE, timeout = 3600)),
    error = function(error) {
      stop(sprintf("nothing answers at %s: start the server (espalier serve --listen %s), or correct the address", address, address), call. = FALSE)
    }
  )
  on.exit(close(server))
  say <- function(...) writeLines(paste0('{"jsonrpc":"2.0",', ..., "}"), server)
  ask <- function(...) {
    say(...)
    line <- readLines(server, 1)
    if (length(line) == 0 || grepl('"error":', line, fixed = TRUE)) stop(paste("The server refused:", line))
  }
  secret <- if (is.null(token) || !nzchar(token)) "" else sprintf(',"token":"%s"', token)
  ask(sprintf('"id":1,"method":"hello","params":{"protocol":[1],"roles":["environment"],"name":"%s","version":"1"%s}',
              name, secret))
  ask(sprintf('"id":2,"method":"environment.offer","params":{"name":"%s"}', name))
  message(name, " is offered")
  while (length(line <- readLines(server, 1)) == 1) {
    id <- json_value(line, "id")
    if (id == line) next  # a notification
    result <- switch(gsub('"', "", json_value(line, "method")),
      environment.describe = sprintf('{"name":"%s","needs":["position","parameters"]}', name),
      environment.step = tryCatch(answer_step(read_queries(line), respond), error = function(problem) problem),
      "{}")  # open, close: nothing to do
    if (inherits(result, "error")) {
      text <- paste0("The environment ", name, " failed: ", conditionMessage(result))
      say('"id":', id, ',"error":{"code":1006,"message":', json_text(text), "}")
    } else {
      say('"id":', id, ',"result":', result)
    }
  }
}
