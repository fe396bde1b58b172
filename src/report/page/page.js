// The page's program: plots that answer to the pointer, and the 3-D view. Without it the page has drawings and a picture.
import uPlot from "uplot";
import plotStyle from "uplot/dist/uPlot.min.css";
import { startView } from "./view.js";

const data = JSON.parse(document.getElementById("data").textContent);
const seriesColours = ["#2f6fb5", "#c4671c", "#6d8f2a"];

function valueText(value) {
  return value == null ? "" : Number(value.toPrecision(4)).toString();
}

function drawPlot(figure, plot) {
  const style = getComputedStyle(document.body);
  const axis = { stroke: style.color, grid: { stroke: "#8883", width: 1 }, ticks: { stroke: "#8886", width: 1 }, size: 62 };
  const bars = uPlot.paths.stepped({ align: 1 });
  // A step holds to the next x, and the last one needs an end.
  const end = plot.bars && plot.x.length > 1 ? [2 * plot.x.at(-1) - plot.x.at(-2)] : [];
  const rows = [[...plot.x, ...end]];
  const series = [{ label: plot.xLabel, value: (_, v) => valueText(v) }];
  plot.series.forEach((s, i) => {
    rows.push([...s.values.map((v) => (plot.log && !(v > 0) ? null : v)), ...end.map(() => s.values.at(-1))]);
    series.push({ label: s.name, stroke: seriesColours[i], width: 2, paths: plot.bars ? bars : undefined,
      points: { show: !plot.bars, size: 6 }, value: (_, v) => valueText(v) });
  });
  if (plot.limit != null) {
    rows.push(rows[0].map(() => plot.limit));
    series.push({ label: "limit", stroke: style.color, dash: [5, 4], points: { show: false }, value: (_, v) => valueText(v) });
  }
  figure.querySelector("svg, .uplot")?.remove();
  const values = (_, ticks) => ticks.map((v) => (v == null ? "" : Number(v.toPrecision(3)).toString()));
  const chart = new uPlot({
    width: figure.clientWidth, height: 280, series,
    scales: { x: { time: false }, y: { distr: plot.log ? 3 : 1 } },
    axes: [{ ...axis, size: 44, label: plot.xLabel, values, ...(plot.bars ? {} : { incrs: [1, 2, 5, 10] }) },
      { ...axis, label: plot.yLabel, values }],
  }, rows);
  figure.prepend(chart.root);
  return chart;
}

function startPlots() {
  if (data.plots.length === 0) return;
  document.head.append(Object.assign(document.createElement("style"), { textContent: plotStyle }));
  const figures = [...document.querySelectorAll("figure.plot")];
  const draw = () => figures.map((figure) => drawPlot(figure, data.plots[figure.dataset.plot]));
  let charts = draw();
  new ResizeObserver(() => {
    for (const [i, chart] of charts.entries())
      if (chart.width !== figures[i].clientWidth) chart.setSize({ width: figures[i].clientWidth, height: 280 });
  }).observe(document.body);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { charts = draw(); });
}

startPlots();
if (data.models) startView(data);
document.documentElement.dataset.ready = "true";
