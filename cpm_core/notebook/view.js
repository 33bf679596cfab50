// Shows the image, the contours and the objects of a View, and sends clicks, keys and the plane to it.

const HTML = `
<svg tabindex="0" data-lm-suppress-shortcuts="true" role="img" aria-label="Image with contours and objects"
  style="width: 100%; max-height: 75vh; background: #101216; cursor: crosshair; touch-action: none">
  <g fill="none" stroke-linejoin="round">
    <image preserveAspectRatio="none" style="image-rendering: pixelated"/>
    <g class="lines"></g>
    <g class="objects"></g>
  </g>
</svg>
<input type="range" min="0" aria-label="Plane" style="width: 100%; margin: 0" hidden>
<div role="status" style="font-size: 90%"></div>`;

function path(d, stroke, fill = "none") {
  const line = (color, width) =>
    `<path d="${d}" vector-effect="non-scaling-stroke" stroke="${color}" stroke-width="${width}"/>`;
  return `<g fill="${fill}" fill-rule="evenodd">${line("#101216", 3.5)}</g>${line(stroke, 1.5)}`;
}

function render({ model, el }) {
  el.innerHTML = HTML;
  const [svg, slider, status] = el.children;
  const all = svg.querySelector("g"), image = svg.querySelector("image");
  let box = null, pressed = null, asked = false;

  const show = (x, y, width, height) => svg.setAttribute("viewBox", (box = [x, y, width, height]).join(" "));
  const place = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(all.getScreenCTM().inverse());
  const send = (name, ...given) => {
    svg.style.cursor = "progress";
    model.send({ do: name, given });
  };
  const ask = () => {  // for one plane at a time, however fast the slider moves
    const { planes, plane } = model.get("ground");
    if (planes && !asked && slider.valueAsNumber !== plane) {
      asked = true;
      send("turn_to", slider.valueAsNumber);
    }
  };

  const drawGround = () => {
    const { picture, lines, shape: [rows, cols], aspect, planes, plane } = model.get("ground");
    URL.revokeObjectURL(image.href.baseVal);
    image.setAttribute("href", URL.createObjectURL(new Blob([picture], { type: "image/png" })));
    for (const [name, value] of Object.entries({ x: -0.5, y: -0.5, width: cols, height: rows })) {
      image.setAttribute(name, value);
    }
    all.setAttribute("transform", `scale(1, ${aspect})`);
    svg.querySelector(".lines").innerHTML = lines.map(([color, d]) => path(d, color)).join("");
    slider.hidden = !planes;
    slider.max = planes - 1;
    if (!box) {
      show(-0.5, -0.5 * aspect, cols, rows * aspect);
      slider.value = plane;
    }
    asked = false;
    ask();
  };
  const drawChosen = () => {
    const { objects, said } = model.get("chosen");
    const look = (selected) => (selected ? ["#f5793a", "#f5793a40"] : ["#0bd3a7", "#0bd3a720"]);
    svg.querySelector(".objects").innerHTML = objects.map(([selected, d]) => path(d, ...look(selected))).join("");
    status.textContent = said;
    svg.style.cursor = "crosshair";
  };

  svg.onpointerdown = (event) => {
    pressed = { x: event.clientX, y: event.clientY, box, moved: false };
    svg.setPointerCapture(event.pointerId);
  };
  svg.onpointermove = (event) => {
    if (!pressed) return;
    const [right, down] = [event.clientX - pressed.x, event.clientY - pressed.y];
    pressed.moved ||= Math.hypot(right, down) > 4;
    if (pressed.moved) {
      const scale = svg.getScreenCTM().a, [x, y, width, height] = pressed.box;
      show(x - right / scale, y - down / scale, width, height);
    }
  };
  svg.onpointerup = (event) => {
    const { x, y } = place(event);
    const { planes, plane } = model.get("ground");
    if (pressed && !pressed.moved) send("click", planes ? [plane, y, x] : [y, x], event.shiftKey);
    pressed = null;
  };
  svg.onwheel = (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const factor = 1.002 ** event.deltaY, [x, y, width, height] = box;
    show(at.x + (x - at.x) * factor, at.y + (y - at.y) * factor, width * factor, height * factor);
  };
  svg.onkeydown = (event) => {
    if (event.key !== "Backspace" && event.key !== "Delete") return;
    event.stopPropagation();
    send("remove");
  };
  slider.oninput = ask;
  model.on("change:ground", drawGround);
  model.on("change:chosen", drawChosen);
  drawGround();
  drawChosen();
  return () => {
    model.off("change:ground", drawGround);
    model.off("change:chosen", drawChosen);
    URL.revokeObjectURL(image.href.baseVal);
  };
}

export default { render };
