// Small charts as inline SVG. Colours come from the page's style sheet through class names, so one chart serves light,
// dark and paper. The same input gives the same bytes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gustlab::svg {

// Text that is safe between tags and in quoted attributes; between a number and its per cent sign no line breaks.
std::string escape(std::string_view text);

enum class Mark { line, dots, points_with_bars };

struct Series {
  std::string style;  // class of the style sheet: measured, before, after, noise, hold
  Mark mark = Mark::line;
  std::vector<double> x, y;  // a value that is not finite breaks the line
  // optional, of y: bars, or a band under a line; on a log axis a bar from 0 or less begins at the chart's lower edge
  std::vector<double> low, high;
};

struct Chart {
  std::string title;  // said by screen readers and shown above
  std::string x_label, y_label;
  bool log_x = false, log_y = false;
  bool zero_y = false;        // the y axis includes zero, which is drawn
  bool equal_scales = false;  // a metre is as long on both axes (neither is logarithmic)
  std::vector<Series> series;
  std::vector<double> marks_x;  // thin vertical lines
  double width = 360.0, height = 230.0;
};
// Empty when no series has a finite point.
std::string draw(const Chart& chart);

// A horizontal bar of `value` with a tick at `reference`, both on a scale from 0 to `full`.
std::string bar(double value, double reference, double full);

// Ticks at round values (1, 2, 5 × 10ⁿ) inside [low, high], about `count` of them; decades and their 2 and 5 when log.
std::vector<double> ticks(double low, double high, int count, bool log);

}  // namespace gustlab::svg
