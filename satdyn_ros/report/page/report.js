'use strict';
// The report plays the run stored in the page itself.

window.satdyn = new Player();
satdyn.take(JSON.parse(document.getElementById('run').textContent));
