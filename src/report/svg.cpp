#include "report/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/text.hpp"

namespace gustlab::svg {

namespace {

constexpr double margin_left = 48.0, margin_right = 10.0, margin_top = 26.0, margin_bottom = 38.0;

// one axis: data → pixels
struct Axis {
  double low, high, from_px, to_px;
  bool log;
  double scaled(double value) const { return log ? std::log10(value) : value; }
  double operator()(double value) const {
    return from_px + (to_px - from_px) * (scaled(value) - scaled(low)) / (scaled(high) - scaled(low));
  }
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }
};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double value, bool log) {
    if (!std::isfinite(value) || (log && value <= 0.0)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

// widens one range until a unit is as long on both axes; `aspect` is width over height of the frame
void make_equal(Range& x, Range& y, double aspect) {
  const auto widen = [](Range& range, double width) {
    const double middle = 0.5 * (range.low + range.high);
    range = {middle - 0.5 * width, middle + 0.5 * width};
  };
  const double width = x.high - x.low, height = y.high - y.low;
  if (width > aspect * height) widen(y, width / aspect);
  else widen(x, aspect * height);
}

Axis make_axis(Range range, bool log, bool zero, double from_px, double to_px, double spare) {
  if (zero) range.add(0.0, false);
  if (log) {
    const double factor = std::pow(std::max(range.high / range.low, 1.5), spare);
    return {range.low / factor, range.high * factor, from_px, to_px, true};
  }
  double width = range.high - range.low;
  if (width == 0.0) width = std::max(std::abs(range.high), 1.0);
  const double low = zero && range.low == 0.0 ? 0.0 : range.low - spare * width;
  return {low, range.high + spare * width, from_px, to_px, false};
}

// as many digits as tell neighbouring ticks apart
std::string tick_text(double value, const std::vector<double>& all, bool log) {
  if (log) return fmt::format("{:.3g}", value);
  double step = std::abs(all.back() - all.front());
  for (std::size_t i = 1; i < all.size(); ++i) step = std::min(step, all[i] - all[i - 1]);
  if (step <= 0.0) step = std::max(std::abs(value), 1.0);
  const double largest = std::max(std::abs(all.front()), std::abs(all.back()));
  if (largest >= 1e5 || largest < 1e-3) return value == 0.0 ? "0" : fmt::format("{:.3g}", value);
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.find_first_not_of("-0.") == std::string::npos) return "0";
  if (text.front() == '-') text = "−" + text.substr(1);
  return text;
}

// room for the labels of the vertical axis: six characters, and for each more the width of a digit
double room_left(const Axis& y) {
  constexpr std::ptrdiff_t characters = 6;
  constexpr double digit_px = 6.5;
  const std::vector<double> at = ticks(y.low, y.high, 4, y.log);
  std::ptrdiff_t longest = characters;
  for (const double value : at)
    longest = std::max(
        longest, std::ranges::count_if(tick_text(value, at, y.log), [](char byte) { return (byte & 0xC0) != 0x80; }));
  return margin_left + digit_px * static_cast<double>(longest - characters);
}

std::string axes(const Chart& chart, const Axis& x, const Axis& y) {
  std::string text;
  const std::vector<double> at_x = ticks(x.low, x.high, 5, x.log), at_y = ticks(y.low, y.high, 4, y.log);
  for (const double value : at_y)
    text += fmt::format(
        "<line class=\"{}\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{}</text>",
        value == 0.0 && y.low < 0.0 ? "zero" : "grid", x.from_px, x.to_px, y(value), y(value), x.from_px - 6.0,
        y(value) + 3.5, tick_text(value, at_y, y.log));
  for (const double value : at_x)
    text += fmt::format(
        "<line class=\"tick\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\"/><text x=\"{0:.1f}\" "
        "y=\"{3:.1f}\" text-anchor=\"middle\">{4}</text>",
        x(value), y.from_px, y.from_px + 4.0, y.from_px + 15.0, tick_text(value, at_x, x.log));
  text += fmt::format("<line class=\"axis\" x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>", x.from_px,
                      x.to_px, y.from_px);
  text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", 0.5 * (x.from_px + x.to_px),
                      chart.height - 6.0, escape(chart.x_label));
  text += fmt::format("<text class=\"head\" x=\"{:.1f}\" y=\"14\">{}</text>", 0.0, escape(chart.title));
  text += fmt::format("<text x=\"{:.1f}\" y=\"14\" text-anchor=\"end\">{}</text>", x.to_px, escape(chart.y_label));
  return text;
}

std::string draw_line(const Series& series, const Axis& x, const Axis& y) {
  std::string path;
  bool pen_down = false;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    const bool shown = x.shows(series.x[i]) && y.shows(series.y[i]);
    if (shown) path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", x(series.x[i]), y(series.y[i]));
    pen_down = shown;
  }
  return path.empty() ? "" : fmt::format("<path class=\"{}\" d=\"{}\"/>", series.style, path);
}

std::string draw_bars(const Series& series, const Axis& x, const Axis& y) {
  std::string text;
  for (std::size_t i = 0; i < std::min({series.x.size(), series.low.size(), series.high.size()}); ++i)
    if (x.shows(series.x[i]) && std::isfinite(series.low[i]) && y.shows(series.high[i]))
      text += fmt::format("<line class=\"{} whisker\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>",
                          series.style, x(series.x[i]), x(series.x[i]),
                          y.shows(series.low[i]) ? y(series.low[i]) : y.from_px, y(series.high[i]));
  return text;
}

std::string draw_dots(const Series& series, const Axis& x, const Axis& y, double radius) {
  std::string text;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
    if (x.shows(series.x[i]) && y.shows(series.y[i]))
      text += fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>", series.style,
                          x(series.x[i]), y(series.y[i]), radius);
  return text;
}

}  // namespace

std::string escape(std::string_view whole) {
  const std::string text_of_page = config::valid_utf8(whole);
  const std::string_view text = text_of_page;
  std::string safe;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    switch (c) {
      case ' ':  // a per cent sign begins no line
        safe += text.substr(i + 1).starts_with('%') ? "&#160;" : " ";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        // control characters are no HTML
        safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return safe;
}

namespace {

std::vector<double> multiples(double low, double high, double step) {
  std::vector<double> found;
  for (auto k = static_cast<long>(std::ceil(low / step - 1e-9)); static_cast<double>(k) * step <= high + 1e-9 * step;
       ++k)
    found.push_back(static_cast<double>(k) * step);
  return found;
}

}  // namespace

std::vector<double> ticks(double low, double high, int count, bool log) {
  constexpr std::size_t fewest = 3;
  std::vector<double> found;
  if (!(high > low)) return {low};
  if (log) {
    const double decades = std::log10(high / low);
    const int first = static_cast<int>(std::floor(std::log10(low))),
              last = static_cast<int>(std::ceil(std::log10(high)));
    for (int decade = first; decade <= last; ++decade)
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double value = digit * std::pow(10.0, decade);
        if (value >= low && value <= high && (digit == 1.0 || decades < 1.9)) found.push_back(value);
      }
    if (found.empty()) found = {low, high};
    return found;
  }
  const double raw = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double digit : {1.0, 2.0, 5.0, 10.0})
    if (raw <= digit * power * (1.0 + 1e-12)) {
      found = multiples(low, high, digit * power);
      // of one or two ticks nobody reads a size
      if (found.size() < fewest) found = multiples(low, high, (digit == 5.0 ? 2.0 : 0.5 * digit) * power);
      break;
    }
  return found;
}

std::string draw(const Chart& chart) {
  Range range_x, range_y;
  for (const Series& series : chart.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) continue;
      range_x.add(series.x[i], chart.log_x);
      range_y.add(series.y[i], chart.log_y);
      if (i < series.low.size()) range_y.add(series.low[i], chart.log_y);
      if (i < series.high.size()) range_y.add(series.high[i], chart.log_y);
    }
  }
  if (range_x.empty() || range_y.empty()) return "";
  if (chart.equal_scales)
    make_equal(range_x, range_y,
               (chart.width - margin_right - margin_left) / (chart.height - margin_bottom - margin_top));
  const Axis y = make_axis(range_y, chart.log_y, chart.zero_y, chart.height - margin_bottom, margin_top,
                           chart.equal_scales ? 0.04 : 0.07);
  const Axis x = make_axis(range_x, chart.log_x, false, room_left(y), chart.width - margin_right, 0.04);

  std::string text = fmt::format("<svg viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"{}\">", chart.width,
                                 chart.height, escape(chart.title));
  text += axes(chart, x, y);
  for (const double mark : chart.marks_x)
    if (x.shows(mark))
      text += fmt::format("<line class=\"mark\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\"/>", x(mark),
                          y.from_px, y.to_px);
  for (const Series& series : chart.series) {
    text += draw_bars(series, x, y);
    if (series.mark != Mark::dots) text += draw_line(series, x, y);
    if (series.mark == Mark::dots) text += draw_dots(series, x, y, 1.6);
    if (series.mark == Mark::points_with_bars) text += draw_dots(series, x, y, 3.0);
  }
  return text + "</svg>";
}

std::string bar(double value, double reference, double full) {
  if (!(full > 0.0) || !std::isfinite(value)) return "";
  const double width = 120.0 * std::clamp(value / full, 0.0, 1.0);
  std::string text = fmt::format(
      "<svg class=\"bar\" viewBox=\"0 0 124 12\" aria-hidden=\"true\"><rect class=\"back\" x=\"0\" y=\"2\" "
      "width=\"124\" height=\"8\" rx=\"2\"/><rect class=\"value\" x=\"0\" y=\"2\" width=\"{:.1f}\" "
      "height=\"8\" rx=\"2\"/>",
      std::max(width, 1.0));
  if (std::isfinite(reference))
    text += fmt::format("<line class=\"reference\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"0\" y2=\"12\"/>",
                        120.0 * std::clamp(reference / full, 0.0, 1.0) + 0.5);
  return text + "</svg>";
}

}  // namespace gustlab::svg
