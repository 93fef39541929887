#include "report/page_style.hpp"

namespace gustlab::report {

std::string_view page_style() {
  return R"css(
:root { color-scheme: light dark; --ink: #1d2733; --soft: #5b6876; --faint: #d9dfe5; --paper: #fbfcfd; --card: #ffffff;
  --before: #c9741a; --after: #1f6fb2; --measured: #1d2733; --warn: #a8480f; --warn-back: #fdf3e7; --good: #2c7a4b; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e9ee; --soft: #9aa7b4; --faint: #313b46; --paper: #14191f;
  --card: #1a2129; --before: #f0a24e; --after: #64b0ec; --measured: #e4e9ee; --warn: #f3b07c; --warn-back: #2b221a;
  --good: #7cc99a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", "Noto Sans",
  "DejaVu Sans", sans-serif; overflow-wrap: anywhere; }
main { max-width: 66rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
header p.kind { margin: 0; color: var(--soft); font-size: .9rem; }
h1 { font-size: clamp(1.2rem, 1.05rem + .9vw, 1.6rem); line-height: 1.38; font-weight: 500; margin: .6rem 0 1rem;
  max-width: 48rem; text-wrap: pretty; }
h2 { font-size: 1.15rem; font-weight: 600; margin: 3rem 0 .4rem; padding-top: 1.2rem; border-top: 1px solid var(--faint); }
h3 { font-size: 1.05rem; font-weight: 600; margin: 0; }
p { margin: .4rem 0 .8rem; max-width: 46rem; }
.note, figcaption, .soft { color: var(--soft); font-size: .88rem; }
.lead { color: var(--ink); margin-top: .8rem; }
ol.headlines { padding-left: 1.3rem; margin: 1rem 0 .6rem; max-width: 46rem; }
ol.headlines li { margin: .55rem 0; } ol.headlines p { margin: .05rem 0 0; }
ol.headlines strong { font-weight: 600; } .sure { color: var(--good); white-space: nowrap; font-variant-numeric: tabular-nums; }
.notice { color: var(--soft); font-size: .92rem; }
.badge { display: inline-block; padding: .05rem .6rem; border: 1px solid currentColor; border-radius: 1rem;
  font-size: .85rem; color: var(--after); }
.badge.consistent { color: var(--good); } .badge.unexplained, .badge.partly { color: var(--before); }
.badge.insufficient { color: var(--soft); }
.findings { background: var(--warn-back); border-left: 3px solid var(--warn); border-radius: 4px; padding: .8rem 1.1rem;
  margin: 1.2rem 0; }
.findings h2 { border: 0; padding: 0; margin: 0 0 .3rem; color: var(--warn); }
.findings ul { margin: 0; padding-left: 1.1rem; }
.effect { background: var(--card); border: 1px solid var(--faint); border-radius: 8px; padding: 1rem 1.2rem; margin: .9rem 0; }
.effect > p { margin: .2rem 0 .6rem; }
.effect .head { display: flex; flex-wrap: wrap; gap: .3rem 1rem; align-items: baseline; justify-content: space-between; }
/* a shadow at the edge behind which more can be scrolled to */
.scroll { overflow-x: auto; --back: var(--paper); --shade: color-mix(in srgb, var(--ink) 28%, transparent);
  background: linear-gradient(to right, var(--back) 40%, transparent) 0 0 / 2.5rem 100% no-repeat local,
  linear-gradient(to left, var(--back) 40%, transparent) 100% 0 / 2.5rem 100% no-repeat local,
  linear-gradient(to right, var(--shade), transparent) 0 0 / .9rem 100% no-repeat scroll,
  linear-gradient(to left, var(--shade), transparent) 100% 0 / .9rem 100% no-repeat scroll; }
.effect .scroll { --back: var(--card); }
table { border-collapse: collapse; font-size: .92rem; margin: .5rem 0; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 500; color: var(--soft); }
th, td { padding: .28rem 1.1rem .28rem 0; vertical-align: top; border-bottom: 1px solid var(--faint);
  overflow-wrap: normal; } td.where { min-width: 12rem; }
tr:last-child td { border-bottom: 0; }
td.n, th.n { text-align: right; white-space: nowrap; }
figure { margin: .8rem 0 0; }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 22rem), 1fr)); gap: 1.2rem 1.6rem; }
figcaption { margin-top: .5rem; max-width: 46rem; }
.legend { display: flex; flex-wrap: wrap; gap: .2rem 1.3rem; font-size: .88rem; color: var(--soft); margin: .5rem 0 .7rem;
  padding: 0; list-style: none; }
.legend svg { width: 26px; height: 10px; margin-right: .4rem; }
details summary { cursor: pointer; color: var(--soft); font-size: .88rem; }
pre { white-space: pre-wrap; }
code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .88em; }
footer { margin-top: 3rem; padding-top: 1rem; border-top: 1px solid var(--faint); color: var(--soft); font-size: .85rem; }
svg { display: block; width: 100%; height: auto; }
svg text { font-size: 11px; fill: var(--soft); font-family: inherit; } svg text.head { fill: var(--ink); font-size: 12px; }
svg .grid { stroke: var(--faint); stroke-width: 1; opacity: .7; } svg .axis, svg .tick { stroke: var(--soft); stroke-width: 1; }
svg .zero { stroke: var(--soft); stroke-width: 1; opacity: .6; } svg .mark { stroke: var(--soft); stroke-dasharray: 1 4; opacity: .6; }
svg path { fill: none; stroke-width: 1.8; stroke-linejoin: round; stroke-linecap: round; }
svg path.measured { stroke: var(--measured); stroke-width: 1.3; opacity: .85; }
svg path.before, svg line.before { stroke: var(--before); } svg path.after, svg line.after { stroke: var(--after); }
svg path.noise { stroke: var(--soft); stroke-dasharray: 5 4; stroke-width: 1.4; }
svg path.hold { stroke: var(--soft); stroke-dasharray: 1.5 4; stroke-width: 1.4; }
svg path.many { stroke-width: 1.3; opacity: .9; } svg path.reference { stroke: var(--soft); stroke-dasharray: 4 3; stroke-width: 1.2; }
svg .whisker.many { stroke-width: 1; opacity: .5; } svg .m1 { stroke: #0072b2; } svg .m2 { stroke: #d55e00; }
svg .m3 { stroke: #009e73; } svg .m4 { stroke: #cc79a7; } svg .m5 { stroke: #e69f00; } svg .m6 { stroke: #56b4e9; }
svg .m7 { stroke: #8a7f00; } svg .m8 { stroke: #7f7f7f; }
svg circle.m1 { fill: #0072b2; } svg circle.m2 { fill: #d55e00; } svg circle.m3 { fill: #009e73; } svg circle.m4 { fill: #cc79a7; }
svg circle.m5 { fill: #e69f00; } svg circle.m6 { fill: #56b4e9; } svg circle.m7 { fill: #8a7f00; } svg circle.m8 { fill: #7f7f7f; }
table.heat td { text-align: center; white-space: nowrap; border: 2px solid var(--paper); padding: .3rem .5rem;
  background: color-mix(in srgb, var(--before) calc(var(--heat, 0) * 65%), var(--card)); }
table.heat th { padding: .3rem .5rem; } table.heat th.n { text-align: center; }
svg circle.before { fill: var(--before); } svg circle.after { fill: var(--after); } svg circle.cloud { fill: var(--before); opacity: .28; }
svg .whisker { stroke-width: 1.3; opacity: .7; }
svg.bar { width: 124px; max-width: 124px; } svg.bar { margin-top: .4rem; }
table.errors { font-size: .86rem; } table.errors th, table.errors td { padding-right: .6rem; } table.errors svg.bar { width: 48px; }
svg.bar .back { fill: var(--faint); opacity: .5; } svg.bar .value { fill: var(--before); } svg.bar .reference { stroke: var(--ink); stroke-width: 1.5; }
@media (prefers-color-scheme: dark) { svg .m1 { stroke: #58a9e0; } svg circle.m1 { fill: #58a9e0; } svg .m2 { stroke: #f08a4b; }
  svg circle.m2 { fill: #f08a4b; } svg .m3 { stroke: #3fc79a; } svg circle.m3 { fill: #3fc79a; } }
@media (max-width: 40rem) { svg.bar { width: 64px; } table { font-size: .86rem; } th, td { padding-right: .7rem; }
  td:not(.n) { min-width: 4.5rem; } td.unit { min-width: 5rem; } td.where { min-width: 12rem; }
  /* columns of words, one below the other */
  table.wrap tr:first-child { display: none; } table.wrap tr, table.wrap td { display: block; }
  table.wrap tr { padding: .5rem 0; border-bottom: 1px solid var(--faint); } table.wrap td { border: 0; padding: 0; }
  table.wrap td:first-child { font-weight: 600; } table.wrap td:last-child { color: var(--soft); }
   main { padding: 1.5rem 1rem 3rem; } }
/* a row of figures is a card on a phone: the cell that names it, then each figure under its title */
@media (max-width: 30rem) { table.cards, table.cards tbody { display: block; } table.cards tr:first-child { display: none; }
  table.cards tr { display: grid; grid-template-columns: repeat(3, 1fr); gap: .15rem .8rem; padding: .6rem 0;
  border-bottom: 1px solid var(--faint); }
  .effect table.cards tr { grid-template-columns: repeat(2, 1fr); }
  table.cards td, table.cards td.where { border: 0; padding: 0; min-width: 0; text-align: left; }
  table.cards td.n { white-space: normal; } table.cards td:empty { display: none; }
  table.cards td.name { order: -1; font-weight: 600; } table.cards td.name, table.cards td.where { grid-column: 1 / -1; }
  /* the name of a flight is long */
  table.cards td { overflow-wrap: anywhere; }
  table.cards td[data-label]::before { content: attr(data-label); display: block; color: var(--soft); font-size: .78rem; }
  table.cards td.name::before { content: none; }
  table.heat th:first-child { position: sticky; left: 0; background: var(--paper); } }
@media print { :root { --ink: #000; --soft: #444; --faint: #ccc; --paper: #fff; --card: #fff; --before: #b5610c; --after: #1a5f9a;
  --measured: #000; --warn: #803300; --warn-back: #fff; --good: #205a37; }
  body { font-size: 11pt; } main { padding: 0; max-width: none; } .effect, figure, tr, .findings { break-inside: avoid; }
  h2 { break-after: avoid; } details { display: block; } }
)css";
}

}  // namespace gustlab::report
