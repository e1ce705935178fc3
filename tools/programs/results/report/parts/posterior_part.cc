// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/posterior_part.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>

#include "losses/image/image.h"
#include "losses/outline/shape_features.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart_json.h"
#include "solver/posterior/posterior_io.h"
#include "tools/programs/results/report/parts/html_text.h"

namespace drape {
namespace {

constexpr int kMostMarginals = 5;
constexpr int kSteps = 80;  // of a curve
constexpr char kBlue[] = "#0072b2", kGrey[] = "#8a8f98";

ChartSeries Density(const std::string& title, double mean, double sd, double reach,
                    const char* colour) {
  ChartSeries series{.title = title, .colour = colour};
  for (int k = 0; k <= kSteps; ++k) {
    const double x = reach * (2.0 * k / kSteps - 1), z = (x - mean) / sd;
    series.points.emplace_back(std::exp(x), std::exp(-0.5 * z * z) / (sd * std::sqrt(2 * M_PI)));
  }
  return series;
}

// The pairs (i, j) with the share `share` of a plane normal distribution inside.
ChartSeries Ellipse(const std::string& title, const StoredPosterior& p, int i, int j, double share,
                    const char* colour, bool dashed) {
  Eigen::Matrix2d covariance;
  covariance << p.covariance(i, i), p.covariance(i, j), p.covariance(j, i), p.covariance(j, j);
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  const double radius = std::sqrt(-2 * std::log(1 - share));
  ChartSeries series{.title = title, .colour = colour, .dashed = dashed};
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 2 * M_PI * k / kSteps;
    const Eigen::Vector2d at = Eigen::Vector2d(p.mean[i], p.mean[j]) +
                               radius * (root * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    series.points.emplace_back(std::exp(at.x()), std::exp(at.y()));
  }
  return series;
}

// The log factors that the data narrow most, those first.
std::vector<int> MostNarrowed(const StoredPosterior& p) {
  std::vector<int> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  const auto ratio = [&](int i) { return std::sqrt(p.covariance(i, i)) / p.prior_sd[i]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return ratio(a) < ratio(b); });
  order.resize(std::min<std::size_t>(order.size(), kMostMarginals));
  return order;
}

// On the diagonal the densities, below it the pairs.
Picture Corner(const StoredPosterior& p) {
  const std::vector<int> shown = MostNarrowed(p);
  Picture picture{.columns = static_cast<int>(shown.size())};
  for (std::size_t row = 0; row < shown.size(); ++row)
    for (std::size_t column = 0; column < shown.size(); ++column) {
      const int i = shown[column], j = shown[row];
      Chart chart;
      if (row == column) {
        chart.title = p.NameFor(i);
        chart.x = {.label = "factor on " + p.NameFor(i), .log = true};
        chart.y = {.label = "density"};
        const double reach = 2.5 * p.prior_sd[i];
        chart.series = {
            Density("prior", 0, p.prior_sd[i], reach, kGrey),
            Density("posterior", p.mean[i], std::sqrt(p.covariance(i, i)), reach, kBlue)};
      } else if (column < row) {
        chart.x = {.label = p.NameFor(i), .log = true};
        chart.y = {.label = p.NameFor(j), .log = true};
        chart.series = {Ellipse("50 %", p, i, j, 0.5, kBlue, false),
                        Ellipse("90 %", p, i, j, 0.9, kBlue, true)};
      }
      picture.charts.push_back(std::move(chart));
    }
  return picture;
}

std::string PosteriorTable(const nlohmann::json& numbers) {
  std::vector<CellRow> rows;
  for (const nlohmann::json& number : numbers) {
    const auto mean = FindNumber(number, "/mean"), sd = FindNumber(number, "/sd"),
               prior = FindNumber(number, "/prior_sd");
    if (!mean || !sd || !prior) continue;
    const bool measured = *sd < 0.7 * *prior;
    rows.push_back({{FindText(number, "/name"), Cell::Kind::kHeader},
                    NumberCell(Format("%.3g", std::exp(*mean))),
                    NumberCell(Format("%.3g … %.3g", std::exp(*mean - 1.645 * *sd),
                                      std::exp(*mean + 1.645 * *sd))),
                    NumberCell(Format("%.2f", *sd / *prior)),
                    OriginCell(measured ? "measured" : "prior")});
  }
  return rows.empty() ? ""
                      : HtmlTable("Factors on the entries of the base tables",
                                  {"entries", "median", "90 % interval",
                                   "posterior over prior deviation", "where from"},
                                  rows);
}

std::string Posterior(const ResultFolder& folder, ReportPage* page) {
  const nlohmann::json* posterior = Find(folder.summary, "/posterior");
  if (posterior == nullptr) return "";
  std::string html;
  const auto k = FindNumber(folder.summary, "/posterior/pareto_k");
  if (k)
    html += HtmlElement(
        "p", Format("Pareto k %.2f: ", *k) +
                 (*k < 0.7 ? "the intervals are reliable." : "do not use these intervals."));
  if (std::filesystem::is_regular_file(folder.File("posterior.json"))) try {
      const StoredPosterior stored = ReadPosterior(folder.path, {NegativeEntries::kWarn});
      if (stored.kind == PosteriorKind::kHierarchy && stored.size() > 0)
        html += page->AddPicture(PictureJson(Corner(stored)),
                                 "Densities over that of the prior, and pairs of factors: what the "
                                 "data narrow most.");
    } catch (const InputError& error) {
      html += HtmlElement("p", error.what(), "missing");
    }
  if (const nlohmann::json* numbers = Find(*posterior, "/log_factors"))
    html += PosteriorTable(*numbers);
  return html;
}

// The numbers of a feature over the drapes that were seen.
std::vector<double> Values(const nlohmann::json& summary, const char* feature) {
  std::vector<double> values;
  for (const nlohmann::json& drape : FindList(summary, "/drapes"))
    if (const auto value = FindNumber(drape, std::string("/") + feature)) values.push_back(*value);
  return values;
}

// At most about six.
std::vector<std::pair<double, std::string>> WholeTicks(long first, long last) {
  const long step = std::max(1L, (last - first + 4) / 5);
  std::vector<std::pair<double, std::string>> ticks;
  for (long value = first; value <= last; value += step)
    ticks.emplace_back(value, std::to_string(value));
  return ticks;
}

Chart Bars(const std::string& label, const std::vector<double>& values, double width) {
  std::map<long, int> counts;
  for (const double value : values) ++counts[std::lround(value / width)];
  ChartSeries bars{.mark = Mark::kSteps, .colour = kBlue};
  const bool whole = width == 1.0;
  if (whole) bars.mark = Mark::kBars;
  if (counts.empty()) return {};
  for (long bin = counts.begin()->first - 1; bin <= counts.rbegin()->first + 1; ++bin)
    bars.points.emplace_back(width * (static_cast<double>(bin) - (whole ? 0.0 : 0.5)),
                             counts.contains(bin) ? counts[bin] : 0);
  Chart chart{.x = {.label = label}, .y = {.label = "drapes"}, .series = {bars}};
  int most = 0;
  for (const auto& [bin, count] : counts) most = std::max(most, count);
  chart.y.ticks = WholeTicks(0, most);
  if (whole) chart.x.ticks = WholeTicks(counts.begin()->first, counts.rbegin()->first);
  return chart;
}

std::string Intervals(const nlohmann::json& features) {
  struct Reading {
    const char* text;
    double factor;
  };
  const std::pair<const char*, Reading> readings[] = {
      {"dc", {"drape coefficient [%]", 100}},
      {"folds", {"nodes", 1}},
      {"band_2", {"waves of the outline, 2 around [mm²]", 1e6}},
      {"band_3_5", {"3 to 5 around [mm²]", 1e6}},
      {"band_6_9", {"6 to 9 around [mm²]", 1e6}},
      {"band_10_15", {"10 to 15 around [mm²]", 1e6}}};
  std::vector<CellRow> rows;
  for (const auto& [key, reading] : readings) {
    if (!features.contains(key)) continue;
    const nlohmann::json& feature = features.at(key);
    const auto number = [&](const char* where) {
      return NumberText(feature, where, reading.factor, "%.3g");
    };
    rows.push_back({{reading.text, Cell::Kind::kHeader},
                    NumberCell(number("/mean")),
                    NumberCell(number("/sd")),
                    NumberCell(number("/interval_50/low") + " … " + number("/interval_50/high")),
                    NumberCell(number("/interval_90/low") + " … " + number("/interval_90/high"))});
  }
  return HtmlTable("", {"feature", "mean", "standard deviation", "50 % in", "90 % in"}, rows);
}

// The outermost radius on a ray at which a mean image has at least this coverage [px].
double RadiusAt(const GrayImage& image, double angle, double coverage) {
  const double cx = 0.5 * (image.width - 1), cy = 0.5 * (image.height - 1);
  for (double r = std::min(cx, cy) - 1; r > 0; r -= 0.25) {
    const int column = static_cast<int>(std::lround(cx + r * std::cos(angle)));
    const int row = static_cast<int>(std::lround(cy - r * std::sin(angle)));
    if (image.at(column, row) >= coverage) return r;
  }
  return 0.0;
}

std::string Contour(const GrayImage& image, double coverage) {
  constexpr int kAngles = 360;
  const double cx = 0.5 * (image.width - 1), cy = 0.5 * (image.height - 1);
  std::string path;
  for (int k = 0; k < kAngles; ++k) {
    const double angle = 2 * M_PI * k / kAngles, r = RadiusAt(image, angle, coverage);
    path += Format("%s%.1f %.1f", k == 0 ? "M" : "L", cx + r * std::cos(angle),
                   cy - r * std::sin(angle));
  }
  return path + "Z";
}

// The area between two contours of the mean image is where the outlines of a share lie.
std::string Bands(const ResultFolder& folder) {
  const std::string file = folder.File("mean_image.png");
  if (!std::filesystem::is_regular_file(file)) return "";
  const GrayImage image = ReadImage(file);
  const auto band = [&](const char* layer, double low, double high) {
    return std::string("<path class=\"") + layer + "\" fill-rule=\"evenodd\" d=\"" +
           Contour(image, low) + Contour(image, high) + "\"/>\n";
  };
  const double scale =
      FindNumber(folder.summary, "/camera/px_per_m").value_or(Camera().pixels_per_metre());
  return Format(
             "<figure><svg class=\"bands\" viewBox=\"0 0 %d %d\" role=\"img\" "
             "aria-label=\"Bands of the outlines of the predicted drapes\">\n",
             image.width, image.height) +
         band("ninety", 0.05, 0.95) + band("half", 0.25, 0.75) + "<path class=\"median\" d=\"" +
         Contour(image, 0.5) + "\"/>\n" +
         Format("<circle class=\"ring\" cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"none\"/>",
                0.5 * (image.width - 1), 0.5 * (image.height - 1),
                folder.Discs().value_or(DrapeDiscs()).support * scale) +
         "</svg>" +
         HtmlElement("figcaption",
                     "Half of the outlines lie in the dark band, 90 % in the light "
                     "one; the line is the median, the dashes are the support.") +
         "</figure>\n";
}

std::string Prediction(const ResultFolder& folder, ReportPage* page) {
  if (folder.program != "drape_predict") return "";
  std::vector<double> coefficients = Values(folder.summary, "dc");
  for (double& value : coefficients) value *= 100;
  std::string html;
  if (!coefficients.empty())
    html += page->AddPicture(
        PictureJson({.charts = {Bars("drape coefficient [%]", coefficients, 2.0),
                                Bars("nodes", Values(folder.summary, "folds"), 1.0)}}),
        "Predicted drapes by drape coefficient and by number of nodes.");
  html += Bands(folder);
  if (const nlohmann::json* features = Find(folder.summary, "/features"))
    html += Intervals(*features);
  if (const nlohmann::json* score = Find(folder.summary, "/score"))
    html += HtmlDetails("Scores on the held-out drapes", HtmlTable("", {}, FlatRows(*score)));
  return html;
}

std::string Spectrum(const ResultFolder& folder, ReportPage* page) {
  const nlohmann::json& values = FindList(folder.summary, "/spectrum/singular_values");
  const auto determined = FindNumber(folder.summary, "/spectrum/determined_directions");
  if (!folder.IsFit() || !determined) return "";
  const double limit = 1.0 / FindNumber(folder.summary, "/parameters/prior_sigma").value_or(1.0);
  ChartSeries above{.title = "determined by the data", .mark = Mark::kPoints, .colour = kBlue},
      below{.title = "of the prior", .mark = Mark::kPoints, .colour = kGrey},
      cut{.title = "1/σ of the prior", .dashed = true};
  std::vector<CellRow> rows;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values.at(i).get<double>();
    (value > limit ? above : below).points.emplace_back(i + 1, value);
    rows.push_back({NumberCell(std::to_string(i + 1)),
                    NumberCell(Format("%.4g", value)),
                    {value > limit ? "determined" : "of the prior"}});
  }
  cut.points = {{0.5, limit}, {static_cast<double>(values.size()) + 0.5, limit}};
  const Chart chart{
      .x = {.label = "direction", .ticks = WholeTicks(1, static_cast<long>(values.size()))},
      .y = {.label = "singular value", .log = true},
      .series = {above, below, cut}};
  return page->AddPicture(PictureJson({.charts = {chart}}),
                          Format("%.0f of %zu directions of the log factors are determined: there "
                                 "the data say more than the prior.",
                                 *determined, values.size())) +
         HtmlDetails("Singular values", HtmlTable("", {"direction", "value", ""}, rows));
}

}  // namespace

void AddPosteriors(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("posterior", "Posterior", SideBySide(folders, [&](const auto& folder) {
                     return Posterior(folder, page);
                   }));
}

void AddPredictions(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("prediction", "Prediction", SideBySide(folders, [&](const auto& folder) {
                     return Prediction(folder, page);
                   }));
}

void AddSpectra(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("spectrum", "What the data determine",
                   SideBySide(folders, [&](const auto& folder) { return Spectrum(folder, page); }));
}

}  // namespace drape
