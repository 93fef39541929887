// What every page must be: well formed, alone, and readable at any width.
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "report/svg.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {

// the first tag that closes nothing, or is never closed; empty when all is well
inline std::string unbalanced(const std::string& html) {
  const std::vector<std::string> empty_tags{"meta", "line", "rect", "circle", "path"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return html.substr(at, 40);
    std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.starts_with("!")) continue;
    const bool closes = tag.starts_with("/");
    const std::string name = tag.substr(closes, tag.find_first_of(" /\n", closes) - closes);
    if (tag.ends_with("/") || std::count(empty_tags.begin(), empty_tags.end(), name)) continue;
    if (!closes) {
      open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name) return tag;
    open.pop_back();
  }
  return open.empty() ? "" : open.back();
}

inline void expect_sound(const std::string& html) {
  EXPECT_EQ(unbalanced(html), "");
  for (const char* wrong : {"nan", "NaN", "inf", "null", "http:", "https:", "<script", "src=", "@import", "url("})
    EXPECT_THAT(html.substr(html.find("<main>")), testing::Not(testing::HasSubstr(wrong)));
  EXPECT_THAT(html.substr(0, html.find("<main>")), testing::Not(testing::HasSubstr("http")));
}

// What a browser says of the laid out page: overflow in px, tables (but heat maps) that must be scrolled sideways, then each text of a figure that leaves its frame or covers another.
inline constexpr const char* layout_probe = R"js(<script>window.onload = () => {
  const said = [], width = document.documentElement.clientWidth;
  for (const part of document.querySelectorAll('main *')) {
    if (part.closest('.scroll') && !part.classList.contains('scroll')) continue;
    if (part.closest('svg') && part.tagName !== 'svg') continue;
    if (part.getBoundingClientRect().right > width + 1) said.push('wider than the page: ' + part.outerHTML.slice(0, 60));
  }
  for (const part of document.querySelectorAll('details')) part.open = true;
  for (const part of document.querySelectorAll('pre'))
    if (part.scrollWidth > part.clientWidth + 1) said.push('cut off: ' + part.textContent.slice(0, 60));
  for (const part of document.querySelectorAll('.scroll'))
    if (part.scrollWidth > part.clientWidth + 1 && !part.querySelector('table.heat'))
      said.push('scrolls sideways: ' + part.innerHTML.slice(0, 60));
  for (const figure of document.querySelectorAll('svg[role=img]')) {
    const frame = figure.getBoundingClientRect();
    const texts = [...figure.querySelectorAll('text')].map(t => [t.textContent, t.getBoundingClientRect()]);
    texts.forEach(([words, box], i) => {
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.bottom > frame.bottom + 1)
        said.push('leaves its figure: ' + words);
      for (const [others, other] of texts.slice(i + 1))
        if (box.left < other.right && other.left < box.right && box.top + 2 < other.bottom && other.top + 2 < box.bottom)
          said.push('covers another: ' + words + ' | ' + others);
    });
  }
  const note = document.createElement('pre');
  note.id = 'probe';
  note.textContent = 'laid out at ' + width + '\n' + said.join('\n');
  window.parent.document.body.append(note);
};</script>)js";

// A page that shows another at a width of its own: a window of Chromium is never narrower than 500 px.
inline std::string framed(const std::string& html, int width_px) {
  return "<!doctype html><body style=\"margin:0\"><iframe style=\"border:0;height:800px;width:" +
         std::to_string(width_px) + "px\" srcdoc=\"" + svg::escape(html) + "\"></iframe></body>";
}

inline bool chromium_is_here() { return std::system("command -v chromium > /dev/null 2>&1") == 0; }

// What headless Chromium finds wrong with a page that it lays out so wide: a line each, empty when all is well.
inline std::string misfits(const std::string& html, int width_px) {
  const TemporaryFolder folder;
  const std::string page = folder.file("page.html"),
                    probed = html.substr(0, html.find("</head>")) + layout_probe + html.substr(html.find("</head>"));
  std::ofstream(page) << framed(probed, width_px) << std::flush;
  const std::string command =
      "chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir=" + folder.file("profile") +
      " --window-size=1300,900 --dump-dom file://" + page + " 2> /dev/null";
  std::string dom;
  std::array<char, 4096> part{};
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return "chromium cannot be started";
  for (std::size_t n; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;) dom.append(part.data(), n);
  pclose(pipe);
  const std::string mark = "<pre id=\"probe\">laid out at " + std::to_string(width_px) + "\n";
  const std::size_t at = dom.find(mark);
  if (at == std::string::npos) return "chromium laid nothing out at this width";
  return dom.substr(at + mark.size(), dom.find("</pre>", at) - at - mark.size());
}

// At the width of a phone and of a desk; without Chromium it is skipped, and said.
inline void expect_fits(const std::string& html) {
  if (!chromium_is_here()) GTEST_SKIP() << "chromium is not installed: layout not looked at";
  for (const int width_px : {375, 1200}) EXPECT_EQ(misfits(html, width_px), "") << "at " << width_px << " px";
}

}  // namespace gustlab
