#include "plant/mjcf_files.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;
using tinyxml2::XMLAttribute;
using tinyxml2::XMLElement;

constexpr double most_elements = 2000.0;   // after <replicate> and <attach>, whose time grows with the square
constexpr std::size_t most_models = 100;   // MJCF files of one vehicle
constexpr std::size_t deepest_models = 8;  // a model that attaches a model that …

// what a number in an attribute may be at most: MuJoCo allocates, or loops, by it
struct Limit {
  std::string_view element, attribute;  // either empty: every one
  double most;
};
constexpr Limit limits[] = {{"replicate", "count", 1e5},
                            {"hfield", "nrow", 4096},
                            {"hfield", "ncol", 4096},
                            {"texture", "width", 4096},
                            {"texture", "height", 4096},
                            {"mesh", "params", 1000},
                            {"camera", "resolution", 4096},
                            {"numeric", "size", 1e5},
                            {"size", "memory", 1e9},
                            {"size", "", 1e4},
                            {"user", "dim", 32},
                            {"contact", "num", 32},
                            {"", "nsample", 32},
                            {"", "actdim", 32}};
// one rigid body has none of these, and some of them are made of thousands of parts
constexpr std::string_view refused[] = {"composite", "flexcomp", "flex", "deformable", "skin"};

// the numbers of an attribute; a size in bytes may end with a letter, as in "10M"
std::vector<double> numbers_of(const char* text) {
  constexpr std::string_view letters = "KMGTPE";
  std::vector<double> numbers;
  for (char* end = nullptr;; text = end) {
    const double value = std::strtod(text, &end);
    if (end == text) return numbers;
    numbers.push_back(value);
    const auto unit = static_cast<char>(std::toupper(static_cast<unsigned char>(*end)));
    const std::size_t letter = letters.find(unit);
    if (unit == '\0' || letter == std::string_view::npos) continue;
    numbers.back() = std::ldexp(value, 10 * (static_cast<int>(letter) + 1));
    ++end;
  }
}

std::string text_of(const XMLElement& element, const char* attribute) {
  const char* text = element.Attribute(attribute);
  return text ? text : "";
}

// one vehicle's files while they are being read
class Reader {
 public:
  explicit Reader(const std::string& path) : folder_(fs::path(path).parent_path()), root_(canonical(folder_)) {
    files.main = fs::path(path).filename().string();
    read_model(files.main, 0);
  }

  MjcfFiles files;

 private:
  static fs::path canonical(const fs::path& path) {
    std::error_code error;
    const fs::path result = fs::weakly_canonical(path.empty() ? fs::path(".") : fs::absolute(path), error);
    return error ? path : result;
  }

  [[noreturn]] void fail(const std::string& file, int line, const std::string& problem) const {
    throw ConfigError(fmt::format("{}:{}: {}", (folder_ / file).string(), line, problem));
  }

  // the path from the folder, in which it must be
  std::string contained(const fs::path& name, const std::string& from, int line) const {
    const fs::path relative = canonical(folder_ / name).lexically_relative(root_);
    if (name.is_absolute() || name.string().find(':') != std::string::npos || relative.empty() ||
        *relative.begin() == "..")
      fail(from, line,
           fmt::format("\"{}\" is outside the vehicle's folder (a vehicle is one folder); move it there",
                       name.string()));
    return name.lexically_normal().string();
  }

  // how many elements MuJoCo makes of a file
  double read_model(const std::string& name, std::size_t depth) {
    const std::string shown = (folder_ / name).string();
    if (depth > deepest_models || ++models_ > most_models)
      throw ConfigError(
          fmt::format("{}: models attach models without end (or more than {}); make it one body", shown, most_models));
    files.bytes[name] = read_file<ConfigError>(shown);
    tinyxml2::XMLDocument document;
    const std::string& text = files.bytes[name];
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      fail(name, document.ErrorLineNum(), fmt::format("not a model that MuJoCo takes ({})", document.ErrorName()));
    const XMLElement* root = document.RootElement();
    if (root == nullptr || std::string_view(root->Name()) != "mujoco")
      fail(name, root ? root->GetLineNum() : 1,
           "not a model that MuJoCo takes (the outermost element is not <mujoco>)");

    Model model{name, depth, {}, {{}}, 0.0};
    gather(*root, model);
    expand(*root, 1.0, model);
    return model.elements;
  }

  struct Model {
    std::string name;
    std::size_t depth;
    std::map<std::string, double> attached;  // elements of the models that it may attach, by name
    std::vector<fs::path> folders;           // in which its assets may be
    double elements;
  };

  // folders first: they hold for the elements before them, too
  void gather(const XMLElement& element, Model& model) {
    for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
      if (std::string_view(child->Name()) == "compiler")
        for (const char* key : {"meshdir", "texturedir", "assetdir"})
          if (const char* folder = child->Attribute(key)) {
            contained(fs::path(model.name).parent_path() / folder, model.name, child->GetLineNum());
            model.folders.emplace_back(folder);
          }
    }
    for (const XMLElement* asset = element.FirstChildElement("asset"); asset;
         asset = asset->NextSiblingElement("asset"))
      for (const XMLElement* child = asset->FirstChildElement("model"); child;
           child = child->NextSiblingElement("model")) {
        const std::string file = text_of(*child, "file"), name = text_of(*child, "name");
        const std::string path = contained(fs::path(model.name).parent_path() / file, model.name, child->GetLineNum());
        model.attached[name.empty() ? fs::path(file).stem().string() : name] = read_model(path, model.depth + 1);
      }
  }

  // every element, as often as MuJoCo makes it
  void expand(const XMLElement& element, double times, Model& model) {
    const std::string_view name = element.Name();
    const int line = element.GetLineNum();
    if (name == "include")
      fail(model.name, line, "<include> is not read (a vehicle's MJCF is one file); paste the other file into it");
    if (std::find(std::begin(refused), std::end(refused), name) != std::end(refused))
      fail(model.name, line, fmt::format("<{}> is not read (a vehicle is one rigid body); leave it out", name));
    for (const XMLAttribute* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next())
      check(element, *attribute, model);
    if (name == "replicate") times *= std::max(0.0, element.DoubleAttribute("count", 1.0));
    model.elements += times;
    if (name == "attach")
      if (const auto found = model.attached.find(text_of(element, "model")); found != model.attached.end())
        model.elements += times * found->second;
    if (model.elements > most_elements)
      fail(model.name, line,
           fmt::format("more than {:g} elements (with <replicate> and <attach>); use fewer", most_elements));
    for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement())
      expand(*child, times, model);
  }

  void check(const XMLElement& element, const XMLAttribute& attribute, const Model& model) {
    const std::string_view of = element.Name(), name = attribute.Name();
    const auto limit = std::find_if(std::begin(limits), std::end(limits), [&](const Limit& row) {
      return (row.element.empty() || of == row.element) && (row.attribute.empty() || name == row.attribute);
    });
    if (limit != std::end(limits))
      for (const double value : numbers_of(attribute.Value()))
        if (!(value <= limit->most))
          fail(model.name, attribute.GetLineNum(),
               fmt::format("\"{}\" of <{}> is {} (a vehicle has at most {:g})", name, of, attribute.Value(),
                           limit->most));
    if (name.starts_with("file") && of != "model") add_asset(attribute, model);
  }

  // wherever MuJoCo may look for it: below its folder for meshes, for textures, or beside the model
  void add_asset(const XMLAttribute& attribute, const Model& model) {
    const fs::path file = attribute.Value(), here = fs::path(model.name).parent_path();
    if (file.empty()) return;
    bool found = false;
    std::set<std::string> places;
    for (const fs::path& folder : model.folders)
      for (const fs::path& name : {file, file.filename()})
        places.insert(contained(here / folder / name, model.name, attribute.GetLineNum()));
    for (const std::string& place : places) {
      std::error_code error;
      if (!fs::is_regular_file(folder_ / place, error)) continue;
      found = true;
      if (!files.bytes.contains(place)) files.bytes[place] = read_file<ConfigError>((folder_ / place).string());
      check_picture(files.bytes[place], attribute, model);
    }
    if (!found)
      fail(model.name, attribute.GetLineNum(),
           fmt::format("there is no file \"{}\" in the vehicle's folder", file.string()));
  }

  // a PNG says its size in its first bytes, big-endian; a small file can be a large picture
  void check_picture(const std::string& bytes, const XMLAttribute& attribute, const Model& model) const {
    if (!bytes.starts_with("\x89PNG") || bytes.size() < 24) return;
    for (const std::size_t at : {16U, 20U}) {
      unsigned long size = 0;
      for (std::size_t i = at; i < at + 4; ++i) size = size << 8 | static_cast<unsigned char>(bytes[i]);
      if (size > 4096)
        fail(model.name, attribute.GetLineNum(),
             fmt::format("the picture \"{}\" is {} wide or high (at most 4096)", attribute.Value(), size));
    }
  }

  fs::path folder_, root_;
  std::size_t models_ = 0;
};

}  // namespace

MjcfFiles read_mjcf_files(const std::string& path) { return Reader(path).files; }

}  // namespace gustlab
