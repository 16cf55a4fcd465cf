"""The network: convolutions over the stacked pictures, then layers that add the state."""

from itertools import pairwise

import torch
from torch import Tensor, nn

WIDTHS = (16, 32, 48, 64)  # channels of the convolutions, each of which halves the picture
HIDDEN = 128
SCALES = (0.3, 0.05)  # of throttle and steering: errors that count alike
LEAST_DEVIATION = 0.01  # in these scales
SPEED_MPS, SPEED_SCALE_MPS = 5.5, 60.0  # a usual speed, and the one that counts as 1 in the state


class Network(nn.Module):
    """(B, channels, H, W) pictures in 0..1 and (B, 1) speed in.

    Out: (B, 2) throttle and steering, not limited, and (B, 2) the standard deviations of the teacher's from them.
    """

    def __init__(self, channels: int, height_px: int, width_px: int) -> None:
        super().__init__()
        sizes = [channels, *WIDTHS]
        layers: list[nn.Module] = []
        for number, (before, after) in enumerate(pairwise(sizes)):
            kernel = 5 if number == 0 else 3
            layers += [nn.Conv2d(before, after, kernel, 2, kernel // 2, bias=False), nn.BatchNorm2d(after), nn.ReLU()]
        self.convolutions = nn.Sequential(*layers, nn.Flatten())
        with torch.no_grad():
            features = self.convolutions.eval()(torch.zeros(1, channels, height_px, width_px)).shape[1]
        self.convolutions.train()
        self.picture = nn.Sequential(nn.Dropout(0.1), nn.Linear(features, HIDDEN), nn.ReLU())
        self.command = nn.Sequential(nn.Linear(HIDDEN + 1, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, 2))
        self.deviation = nn.Sequential(nn.Linear(HIDDEN + 1, HIDDEN // 2), nn.ReLU(), nn.Linear(HIDDEN // 2, 2))

    def forward(self, image: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Command and deviation. Brightness and contrast of the whole picture are taken out: weather changes them.

        The deviation learns from what the command sees, and does not change it.
        """
        level = image.mean(dim=(1, 2, 3), keepdim=True)
        spread = (image - level).square().mean(dim=(1, 2, 3), keepdim=True).sqrt()
        features = self.picture(self.convolutions((image - level) / (spread + 0.02)))
        faster = state * SPEED_SCALE_MPS - SPEED_MPS
        seen = torch.cat([features, faster], dim=1)
        deviation = nn.functional.softplus(self.deviation(seen.detach())) + LEAST_DEVIATION
        return self.command(seen), deviation * torch.tensor(SCALES)
