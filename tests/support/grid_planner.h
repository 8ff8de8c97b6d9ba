#pragma once

#include <cstdlib>
#include <functional>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include <highwall/mapping/occupancy_grid.h>

namespace highwall {

using Cell = std::pair<int, int>;

inline Cell CellAt(const OccupancyGrid& grid, const Eigen::Vector2d& p_G) {
  const Eigen::Vector2d cell = (p_G - grid.origin_G) / grid.resolution;
  return {static_cast<int>(cell.x()), static_cast<int>(cell.y())};
}

// A* over free cells, in steps of one cell. Returns an empty path if there is none.
inline std::vector<Cell> Plan(const OccupancyGrid& grid, Cell start, Cell goal) {
  const auto estimate = [&](Cell c) {
    return std::abs(c.first - goal.first) + std::abs(c.second - goal.second);
  };
  using Entry = std::pair<int, Cell>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::map<Cell, std::pair<int, Cell>> best;  // cost and predecessor
  open.push({estimate(start), start});
  best[start] = {0, start};
  while (!open.empty()) {
    const auto [total, cell] = open.top();
    open.pop();
    if (cell == goal) break;
    const int cost = best[cell].first;
    for (const auto& [di, dj] : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
      const Cell next{cell.first + di, cell.second + dj};
      if (next.first < 0 || next.second < 0 || next.first >= grid.width ||
          next.second >= grid.height || grid.At(next.first, next.second) != GridCell::kFree) {
        continue;
      }
      const auto known = best.find(next);
      if (known != best.end() && known->second.first <= cost + 1) continue;
      best[next] = {cost + 1, cell};
      open.push({cost + 1 + estimate(next), next});
    }
  }
  std::vector<Cell> path;
  if (!best.contains(goal)) return path;
  for (Cell cell = goal; cell != start; cell = best[cell].second) path.push_back(cell);
  return path;
}

}  // namespace highwall
