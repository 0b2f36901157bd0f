// Stands for studio.js in a program that was built without it: the page says what is missing.
const message = document.getElementById("message");
message.className = "error";
message.textContent =
  "This page cannot show plants: the program was built without the script of its pages, which Node.js makes.\n\n" +
  "Install Node.js 18 or newer with npm (Debian: apt-get install nodejs npm). " +
  "Then configure and build the program again: cmake --preset release && cmake --build --preset release.\n\n" +
  "Everything else of the server works.";
