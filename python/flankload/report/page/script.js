"use strict";
// Values of the curves under the pointer, and the loaded bodies at a chosen position.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const NS = "http://www.w3.org/2000/svg";
  const byId = (id) => document.getElementById(id);

  const short = (value) => {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-3 ? value.toExponential(3) : String(+value.toPrecision(4));
  };

  // --- curves -----------------------------------------------------------------------------------
  // Value of a curve at x, linear between neighbours; null in a gap and beyond the ends.
  const valueAt = ([, xs, ys], x) => {
    for (let k = 1; k < xs.length; k += 1) {
      if (xs[k - 1] === null || xs[k] === null || ys[k - 1] === null || ys[k] === null) continue;
      if (xs[k - 1] <= x && x <= xs[k]) {
        const part = xs[k] > xs[k - 1] ? (x - xs[k - 1]) / (xs[k] - xs[k - 1]) : 0;
        return ys[k - 1] + part * (ys[k] - ys[k - 1]);
      }
    }
    return null;
  };

  const vertical = (svg, name) => {
    const line = document.createElementNS(NS, "line");
    line.setAttribute("class", name);
    line.style.display = "none";
    svg.append(line);
    return line;
  };

  const moveTo = (line, axes, x) => {
    const [left, top, width, height] = axes.box;
    const at = left + (width * (x - axes.x[0])) / (axes.x[1] - axes.x[0]);
    line.style.display = at < left || at > left + width ? "none" : "";
    line.setAttribute("x1", at);
    line.setAttribute("x2", at);
    line.setAttribute("y1", top);
    line.setAttribute("y2", top + height);
  };

  const cursors = [];

  const watch = (figure, plots) => {
    const svg = figure.querySelector("svg");
    const tip = document.createElement("div");
    tip.className = "tip";
    tip.hidden = true;
    figure.append(tip);
    const pointer = vertical(svg, "pointer");
    plots.filter((axes) => axes.position).forEach((axes) => {
      cursors.push([vertical(svg, "cursor"), axes]);
    });
    const hide = () => {
      tip.hidden = true;
      pointer.style.display = "none";
    };
    svg.addEventListener("pointerleave", hide);
    svg.addEventListener("pointermove", (event) => {
      const place = new DOMPoint(event.clientX, event.clientY)
        .matrixTransform(svg.getScreenCTM().inverse());
      const inside = plots.filter(({ box: [left, top, width, height] }) =>
        place.x >= left && place.x <= left + width && place.y >= top && place.y <= top + height);
      if (!inside.length) {
        hide();
        return;
      }
      const lines = [];
      inside.forEach((axes) => {
        const [left, , width] = axes.box;
        const x = axes.x[0] + ((place.x - left) / width) * (axes.x[1] - axes.x[0]);
        if (!lines.length) lines.push(`${short(x)}${axes.position ? "°" : ""}`);
        axes.curves.forEach((curve) => {
          const y = valueAt(curve, x);
          if (y !== null) lines.push(`${curve[0] || axes.label}: ${short(y)}`);
        });
        moveTo(pointer, axes, x);
      });
      tip.replaceChildren(...lines.map((text) => {
        const row = document.createElement("div");
        row.textContent = text;
        return row;
      }));
      tip.hidden = false;
      const frame = figure.getBoundingClientRect();
      const right = event.clientX - frame.left + 14;
      tip.style.left = `${Math.min(right, frame.width - tip.offsetWidth)}px`;
      tip.style.top = `${event.clientY - frame.top + 14}px`;
    });
  };

  Object.entries(data.plots).forEach(([name, plots]) => {
    const figure = byId(`plot-${name}`);
    if (figure) watch(figure, plots);
  });

  // --- position ---------------------------------------------------------------------------------
  const slider = byId("place");
  const torque = byId("torque");
  const play = byId("play");
  let timer = null;

  const row = (cells) => {
    const line = document.createElement("tr");
    cells.forEach((value) => {
      const cell = document.createElement("td");
      cell.className = "number";
      cell.textContent = String(value);
      line.append(cell);
    });
    return line;
  };

  const show = () => {
    const p = Number(slider.value);
    const t = torque ? Number(torque.value) : data.torques.length - 1;
    const state = data.states[t][p];
    data.turn.forEach((angles, z) => {
      byId(`body-${z + 1}`).setAttribute("transform", `rotate(${angles[p]})`);
    });
    byId("loads").replaceChildren(...state.paths.map(([d]) => {
      const path = document.createElementNS(NS, "path");
      path.setAttribute("class", "load");
      path.setAttribute("d", d);
      return path;
    }));
    byId("names").replaceChildren(...state.paths.map(([, x, y], k) => {
      const text = document.createElementNS(NS, "text");
      text.setAttribute("x", x);
      text.setAttribute("y", -y);
      text.textContent = String(state.pairs[k][0]);
      return text;
    }));
    byId("angle").textContent = `${data.deg[p]}°`;
    byId("load").textContent = `${data.torques[t]} N m`;
    byId("error").textContent = `${state.te} µm`;
    document.querySelector("#pairs tbody").replaceChildren(...state.pairs.map(row));
    cursors.forEach(([line, axes]) => moveTo(line, axes, data.deg[p]));
  };

  const stop = () => {
    clearInterval(timer);
    timer = null;
    play.textContent = "▶ rotate";
  };

  const start = () => {
    timer = setInterval(() => {
      slider.value = (Number(slider.value) + 1) % data.deg.length;
      show();
    }, 120);
    play.textContent = "■ stop";
  };

  // The scene is printed, too.
  window.addEventListener("beforeprint", () => {
    document.querySelector("details").open = true;
  });
  slider.addEventListener("input", show);
  if (torque) torque.addEventListener("change", show);
  play.addEventListener("click", () => (timer === null ? start() : stop()));
  if (data.deg.length > 1 || data.torques.length > 1) {
    document.querySelector(".controls").hidden = false;
    if (data.deg.length < 2) {
      slider.parentElement.hidden = true;
      play.hidden = true;
    }
    show();
  }
})();
