surface café() { }
