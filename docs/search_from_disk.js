// The search of pages that were opened from a disk. Browsers start no worker for `file:` and read no file from there: here the search runs in
// the page itself, and its index comes as a script (handbook_hooks.py). Stands before search/main.js of mkdocs, which makes the Worker.
(function () {
  "use strict";
  if (window.location.protocol !== "file:") {
    return;
  }
  const folder = document.currentScript.src;

  function load(name) {
    return new Promise(function (done, failed) {
      const script = document.createElement("script");
      script.src = new URL(name, folder).href;
      script.onload = done;
      script.onerror = failed;
      document.head.append(script);
    });
  }

  window.Worker = class {
    async postMessage(message) {
      if (message.init) {
        await load("lunr.js");
        await load("worker.js");
        await load("search_index.js");
        // worker.js says what it finds by postMessage, as workers do
        window.postMessage = (said) => this.onmessage({ data: said });
        window.data = window.espalierSearchIndex;
        window.onScriptsLoaded();
      } else {
        this.onmessage({ data: { results: window.search(message.query) } });
      }
    }
  };
})();
