'use strict';
// The WebSocket to the server: it reopens when it is lost, and answers go to whoever asked.

class Connection {
  // take: functions by the type of a message; changed(isOpen).
  constructor(take, changed) {
    Object.assign(this, { take, changed, waiting: new Map(), number: 0, isOpen: false });
    this._open();
  }

  // Resolve to the answer {success, text ...}.
  ask(request) {
    if (!this.isOpen) return Promise.resolve({ success: false, text: 'there is no connection to satdyn watch' });
    this.number += 1;
    const { number } = this;
    this.socket.send(JSON.stringify({ id: number, ...request }));
    return new Promise((resolve) => { this.waiting.set(number, resolve); });
  }

  _open() {
    this.socket = new WebSocket(`ws://${location.host}/socket`);
    this.socket.addEventListener('open', () => { this.isOpen = true; this.changed(true); });
    this.socket.addEventListener('close', () => {
      this.isOpen = false;
      this.waiting.forEach((resolve) => resolve({ success: false, text: 'the connection was lost' }));
      this.waiting.clear();
      this.changed(false);
      setTimeout(() => this._open(), 1000);
    });
    this.socket.addEventListener('message', ({ data }) => {
      const message = JSON.parse(data);
      if (message.type !== 'answer') this.take[message.type]?.(message);
      this.waiting.get(message.id)?.(message);
      this.waiting.delete(message.id);
    });
  }
}

// The cookie holds the token now, and a copied address should not contain it.
if (location.search) history.replaceState(null, '', location.pathname);
