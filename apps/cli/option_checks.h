#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include <highwall/frontend/input/dataset.h>

namespace highwall::apps {

// Accepts a number in [min, max]. CLI::Range lets NaN pass.
CLI::Validator Between(double min, double max);

// Adds --max-pair-difference, stored in `seconds` (a double or an optional one).
template <class Seconds>
CLI::Option* AddMaxPairDifference(CLI::App* command, Seconds* seconds) {
  return command
      ->add_option("--max-pair-difference", *seconds,
                   "Between the stamps of the colour and the depth image of a frame [s: 0.02]")
      ->check(Between(1e-6, 1.0));
}

// Adds --fps, stored in `rate` (a double or an optional one).
template <class Rate>
CLI::Option* AddFrameRate(CLI::App* command, Rate* rate) {
  return command
      ->add_option("--fps", *rate,
                   "Rate of the frames, where the recording has no stamps [1/s: 30]")
      ->check(Between(1e-3, 1e4));
}

// Adds --topics, stored in `topics`.
CLI::Option* AddTopics(CLI::App* command, BagTopics* topics);

// Accepts a non-empty name of a file or folder.
CLI::Validator NotEmpty();

// Accepts one of these words; shown as {points,lines,both}.
CLI::Validator OneOf(const std::vector<std::string>& words);

// Returns "{points,lines,both}".
std::string Braces(const std::vector<std::string>& words);

template <class T>
using Choices = std::vector<std::pair<std::string, T>>;

// Returns the choices of an enum, named by ToString().
template <class Enum>
Choices<Enum> Named(const auto& values) {
  Choices<Enum> choices;
  for (const Enum value : values) choices.emplace_back(ToString(value), value);
  return choices;
}

// Adds an option that accepts one of the words and stores the associated value in `value`.
template <class T, class Value>
CLI::Option* AddChoice(CLI::App* command, const std::string& name, Value* value,
                       const Choices<T>& choices, const std::string& help) {
  std::vector<std::string> words;
  for (const auto& choice : choices) words.push_back(choice.first);
  const auto set = [value, choices](const std::string& word) {
    for (const auto& [known, meaning] : choices) {
      if (known == word) *value = meaning;
    }
  };
  return command->add_option_function<std::string>(name, set, help)
      ->type_name(Braces(words))
      ->check(OneOf(words).description(""));
}

}  // namespace highwall::apps
